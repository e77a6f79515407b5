#include "common/geometry/registration/scaling_icp.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using testing::DegreesBetween;
using testing::IsOk;
using testing::MakeSimilarity;
using testing::StatusIs;

constexpr int kRows = 40;

Alignment Align(const Eigen::Matrix3Xd& source,
                const Eigen::Matrix3Xd& target,
                const IcpOptions& options,
                const Similarity& start = {}) {
  const absl::StatusOr<Alignment> alignment = AlignByIcp(source, IcpTarget(target), start, options);
  EXPECT_THAT(alignment, IsOk());
  return alignment.value_or(Alignment{});
}

/// The method as the header describes it, with brute force and the general fit.
Alignment TextbookIcp(const Eigen::Matrix3Xd& source,
                      const Eigen::Matrix3Xd& target,
                      const IcpOptions& options) {
  Alignment alignment;
  double previous = std::numeric_limits<double>::infinity();
  Eigen::Matrix3Xd matched(3, source.cols());
  while (alignment.iterations < options.max_iterations) {
    const Eigen::Matrix3Xd moved = alignment.T_target_source.Apply(source);
    double sum = 0;
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      Eigen::Index nearest = 0;
      sum +=
          std::sqrt((target.colwise() - moved.col(i)).colwise().squaredNorm().minCoeff(&nearest));
      matched.col(i) = target.col(nearest);
    }
    alignment.T_target_source = FitSimilarity(source, matched, options.scale_mode).value();
    ++alignment.iterations;
    const double mean = sum / static_cast<double>(source.cols());
    if (std::abs(previous - mean) <= options.tolerance) {
      alignment.converged = true;
      break;
    }
    previous = mean;
  }
  const Eigen::Matrix3Xd difference = alignment.T_target_source.Apply(source) - matched;
  alignment.rms_residual = std::sqrt(difference.squaredNorm() / static_cast<double>(source.cols()));
  alignment.mean_residual = difference.colwise().norm().mean();
  return alignment;
}

TEST(AlignByIcp, BringsACopyBack) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity moved = MakeSimilarity(1.05, 8, {1, 2, 3}, {3, -4, 5});
  const Alignment alignment = Align(moved.Apply(target), target, {});
  EXPECT_TRUE(alignment.converged);
  EXPECT_LT(DegreesBetween(alignment.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_NEAR(alignment.T_target_source.scale, 1 / 1.05, 1e-4);
  EXPECT_LT(alignment.rms_residual, 1e-3);  // mm; the target is known in float32
}

TEST(AlignByIcp, BringsACopyBackRigidly) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity moved = MakeSimilarity(1, 8, {1, 2, 3}, {3, -4, 5});
  const Alignment alignment = Align(moved.Apply(target), target, {.scale_mode = ScaleMode::kOff});
  EXPECT_LT(DegreesBetween(alignment.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_EQ(alignment.T_target_source.scale, 1);
}

TEST(AlignByIcp, EqualsTheTextbookLoop) {
  const Eigen::Matrix3Xd source = BumpySurface(20, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(25).vertices;
  const IcpOptions options{.max_iterations = 60, .tolerance = 0.003};
  const Alignment alignment = Align(source, target, options);
  const Alignment expected = TextbookIcp(source, target, options);
  EXPECT_EQ(alignment.iterations, expected.iterations);
  EXPECT_TRUE(alignment.converged);
  EXPECT_TRUE(alignment.T_target_source.Matrix().isApprox(expected.T_target_source.Matrix(), 1e-6));
  EXPECT_NEAR(alignment.rms_residual, expected.rms_residual, 1e-5);
  EXPECT_NEAR(alignment.mean_residual, expected.mean_residual, 1e-5);
}

TEST(AlignByIcp, RunsAllIterationsIfTheToleranceIsZero) {
  const Eigen::Matrix3Xd target = BumpySurface(20).vertices;
  const Alignment alignment = Align(target, target, {.max_iterations = 37, .tolerance = 0});
  EXPECT_EQ(alignment.iterations, 37);
  EXPECT_EQ(alignment.lookups, 37 * target.cols());
  EXPECT_FALSE(alignment.converged);
}

TEST(AlignByIcp, CountsOneLookupPerVertexAndIteration) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Alignment alignment = Align(source, BumpySurface(20).vertices, {});
  EXPECT_GT(alignment.iterations, 2);
  EXPECT_EQ(alignment.lookups, alignment.iterations * source.cols());
}

TEST(AlignByIcp, NeedsTwoPassesToConverge) {
  const Eigen::Matrix3Xd target = BumpySurface(20).vertices;
  const Alignment alignment = Align(target, target, {});
  EXPECT_EQ(alignment.iterations, 2);
  EXPECT_TRUE(alignment.converged);
  EXPECT_FALSE(Align(target, target, {.max_iterations = 1}).converged);
}

class IcpScaleModes : public ::testing::TestWithParam<ScaleMode> {};

TEST_P(IcpScaleModes, SquaredErrorNeverRises) {
  const Eigen::Matrix3Xd source = BumpySurface(20, 2, 4).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(25, 3).vertices;
  const Similarity start = MakeSimilarity(1, 25, {1, 1, -1}, {10, 5, 0});
  std::vector<double> residuals;
  for (int iterations = 1; iterations <= 50; ++iterations) {
    const IcpOptions options{
        .scale_mode = GetParam(), .max_iterations = iterations, .tolerance = 0};
    residuals.push_back(Align(source, target, options, start).rms_residual);
  }
  double largest_rise = 0;
  for (size_t i = 1; i < residuals.size(); ++i) {
    largest_rise = std::max(largest_rise, residuals[i] - residuals[i - 1]);
  }
  EXPECT_LT(largest_rise, 1e-6);  // mm: queries are rounded to float32
  EXPECT_LT(residuals.back(), 0.8 * residuals.front());
}
INSTANTIATE_TEST_SUITE_P(BothModes,
                         IcpScaleModes,
                         ::testing::Values(ScaleMode::kOff, ScaleMode::kFree));

TEST(AlignByIcp, DoesNotSeeACommonRigidMotion) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity motion = MakeSimilarity(1, 110, {3, -1, 2}, {500, -300, 40});
  // A fixed number of passes: near the end, one neighbour that flips could stop one run earlier.
  const IcpOptions options{.max_iterations = 15, .tolerance = 0};
  const Alignment still = Align(source, target, options);
  const Alignment moved = Align(motion.Apply(source), motion.Apply(target), options);
  EXPECT_NEAR(moved.rms_residual, still.rms_residual, 1e-4);
  EXPECT_NEAR(moved.T_target_source.scale, still.T_target_source.scale, 1e-5);
  const Similarity back = motion.Inverse() * moved.T_target_source * motion;
  EXPECT_LT(DegreesBetween(back.rotation, still.T_target_source.rotation), 0.01);
}

TEST(AlignByIcp, GivesTheSameBytesAgain) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Alignment first = Align(source, target, {});
  const Alignment second = Align(source, target, {});
  const Eigen::Matrix4d a = first.T_target_source.Matrix();
  const Eigen::Matrix4d b = second.T_target_source.Matrix();
  EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * 16), 0);
  EXPECT_EQ(first.rms_residual, second.rms_residual);
}

TEST(AlignByIcp, ReportsMeanResidualBelowRms) {
  const Alignment alignment =
      Align(BumpySurface(kRows, 2, 3).vertices, BumpySurface(kRows).vertices, {});
  EXPECT_GT(alignment.mean_residual, 0);
  EXPECT_LE(alignment.mean_residual, alignment.rms_residual);
}

TEST(AlignByIcp, RefusesACollapse) {
  const Eigen::Matrix3Xd source = BumpySurface(20).vertices;
  EXPECT_THAT(AlignByIcp(source, IcpTarget(0.01 * source), {}, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "collapse"));
  const Eigen::Matrix3Xd one_vertex = Eigen::Matrix3Xd::Zero(3, 1);
  EXPECT_THAT(AlignByIcp(source, IcpTarget(one_vertex), {}, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "scale"));
}

TEST(AlignByIcp, MeasuresTheCollapseFromTheStart) {
  const Eigen::Matrix3Xd source = BumpySurface(20).vertices;
  Similarity start;
  start.scale = 0.01;
  EXPECT_THAT(AlignByIcp(source, IcpTarget(0.01 * source), start, {}), IsOk());
}

TEST(AlignByIcp, RefusesASourceWithoutExtent) {
  const Eigen::Matrix3Xd source = Eigen::Vector3d(0.1, 0.2, 0.3).replicate(1, 5);
  EXPECT_THAT(AlignByIcp(source, IcpTarget(BumpySurface(20).vertices), {}, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition, ""));
}

TEST(AlignByIcp, RefusesTooFewVertices) {
  EXPECT_THAT(
      AlignByIcp(Eigen::Matrix3Xd::Zero(3, 2), IcpTarget(BumpySurface(20).vertices), {}, {}),
      StatusIs(absl::StatusCode::kInvalidArgument, "2 vertices"));
}

TEST(IcpOptions, RefuseNonsense) {
  EXPECT_THAT(IcpOptions{}.Validate(), IsOk());
  EXPECT_THAT((IcpOptions{.max_iterations = 0}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "max_iterations is 0"));
  EXPECT_THAT((IcpOptions{.tolerance = -1}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "tolerance is -1"));
  EXPECT_THAT((IcpOptions{.tolerance = std::nan("")}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "tolerance"));
  const Eigen::Matrix3Xd points = BumpySurface(20).vertices;
  EXPECT_THAT(AlignByIcp(points, IcpTarget(points), {}, {.max_iterations = -3}),
              StatusIs(absl::StatusCode::kInvalidArgument, "-3"));
}

}  // namespace
}  // namespace cohort
