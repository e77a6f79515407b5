#include "common/analysis/shape_modes.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr Eigen::Index kVertices = 50;

Eigen::Matrix3Xd RandomField(uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3Xd field(3, kVertices);
  for (double& value : field.reshaped()) value = random.Normal();
  return field;
}

/// Shapes common + a_i u + b_i v with u, v orthogonal and of unit RMS, mean scores not zero.
struct TwoModes {
  Eigen::Matrix3Xd common = RandomField(1);
  Eigen::Matrix3Xd u = RandomField(2);
  Eigen::Matrix3Xd v = RandomField(3);
  std::vector<double> a = {5, -3, 1, 4, -2};
  std::vector<double> b = {0.5, 1, -1, 0.25, -0.5};
  std::vector<Eigen::Matrix3Xf> displacements;

  TwoModes() {
    const auto dot = [](const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xd& y) {
      return x.cwiseProduct(y).sum();
    };
    u *= std::sqrt(kVertices / dot(u, u));
    v -= u * (dot(u, v) / dot(u, u));
    v *= std::sqrt(kVertices / dot(v, v));
    for (size_t i = 0; i < a.size(); ++i) {
      displacements.emplace_back((a[i] * u + b[i] * v).cast<float>());
    }
  }
};

TEST(FindShapeModes, RebuildsEveryShapeFromItsScores) {
  const TwoModes truth;
  const auto found = FindShapeModes(truth.displacements, truth.common, 10);
  ASSERT_THAT(found, IsOk());
  for (size_t i = 0; i < truth.a.size(); ++i) {
    Eigen::Matrix3Xd shape = found->mean;
    for (size_t k = 0; k < found->modes.size(); ++k) {
      shape += found->scores(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
               found->modes[k];
    }
    const Eigen::Matrix3Xd wanted = truth.common + truth.displacements[i].cast<double>();
    EXPECT_LT((shape - wanted).cwiseAbs().maxCoeff(), 1e-5);
  }
}

TEST(FindShapeModes, FindsTheVarianceOfTheScores) {
  const TwoModes truth;
  const auto found = FindShapeModes(truth.displacements, truth.common, 2);
  ASSERT_THAT(found, IsOk());
  // Total variance is the sum of those of a and b, however the modes turn.
  const auto variance = [](const std::vector<double>& values) {
    double mean = 0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    double sum = 0;
    for (const double value : values) sum += (value - mean) * (value - mean);
    return sum / static_cast<double>(values.size() - 1);
  };
  EXPECT_NEAR(found->total_variance, variance(truth.a) + variance(truth.b), 1e-5);
  ASSERT_EQ(found->modes.size(), 2U);
  EXPECT_NEAR(found->explained[0] + found->explained[1], 1, 1e-6);
  EXPECT_GT(found->explained[0], 0.9);
  for (size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(found->modes[k].squaredNorm() / kVertices, 1, 1e-9);
    const Eigen::VectorXd scores = found->scores.col(static_cast<Eigen::Index>(k));
    EXPECT_NEAR(scores.sum(), 0, 1e-5);
    EXPECT_NEAR(scores.squaredNorm() / 4, std::pow(found->deviations[k], 2), 1e-9);
    EXPECT_GT(scores.cwiseAbs().maxCoeff(), 0);
    EXPECT_EQ(scores.maxCoeff(), scores.cwiseAbs().maxCoeff());
  }
  EXPECT_NEAR(found->modes[0].cwiseProduct(found->modes[1]).sum(), 0, 1e-6);
}

TEST(FindShapeModes, LeavesOutModesWithoutVariance) {
  const TwoModes truth;
  EXPECT_EQ(FindShapeModes(truth.displacements, truth.common, 100)->modes.size(), 2U);
  const std::vector<Eigen::Matrix3Xf> equal(3, Eigen::Matrix3Xf::Ones(3, kVertices));
  const auto none = FindShapeModes(equal, truth.common, 3);
  ASSERT_THAT(none, IsOk());
  EXPECT_TRUE(none->modes.empty());
  EXPECT_EQ(none->total_variance, 0);
}

TEST(FindShapeModes, RefusesWhatIsNoSet) {
  const TwoModes truth;
  const std::vector<Eigen::Matrix3Xf> one(1, truth.displacements[0]);
  EXPECT_THAT(FindShapeModes(one, truth.common, 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "1 shapes, at least 2"));
  EXPECT_THAT(FindShapeModes(truth.displacements, truth.common, 0).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "0 asked"));
  std::vector<Eigen::Matrix3Xf> unlike = truth.displacements;
  unlike[1].resize(3, 7);
  EXPECT_THAT(FindShapeModes(unlike, truth.common, 1).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "7 vertices among those of 50"));
}

}  // namespace
}  // namespace cohort
