#include "common/geometry/registration/similarity.h"

#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::DegreesBetween;
using testing::IsOk;
using testing::MakeSimilarity;
using testing::StatusIs;

/// A few hundred roundings of numbers about 100.
constexpr double kRounding = 1e-10;

Eigen::Matrix3Xd RandomPoints(Eigen::Index count, uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    points.col(i) << random.Uniform(-50, 50), random.Uniform(-80, 80), random.Uniform(-20, 20);
  }
  return points;
}

double SquaredError(const Similarity& T, const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return (T.Apply(a) - b).squaredNorm();
}

TEST(FitSimilarity, RecoversAKnownPose) {
  const Eigen::Matrix3Xd source = RandomPoints(100, 1);
  const Similarity truth = MakeSimilarity(1.3, 77, {1, -2, 0.5}, {10, -200, 3});
  const auto T = FitSimilarity(source, truth.Apply(source), ScaleMode::kFree);
  ASSERT_THAT(T, IsOk());
  EXPECT_NEAR(T->scale, 1.3, kRounding);
  EXPECT_TRUE(T->rotation.isApprox(truth.rotation, kRounding));
  EXPECT_TRUE(T->translation.isApprox(truth.translation, kRounding));
}

TEST(FitSimilarity, RecoversAHalfTurn) {
  const Eigen::Matrix3Xd source = RandomPoints(50, 1);
  const Similarity truth = MakeSimilarity(1, 180, {0, 0, 1}, {1, 2, 3});
  const auto T = FitSimilarity(source, truth.Apply(source), ScaleMode::kFree);
  ASSERT_THAT(T, IsOk());
  EXPECT_LT(SquaredError(*T, source, truth.Apply(source)), kRounding);
}

TEST(FitSimilarity, IsAsExactFarFromTheOrigin) {
  const Eigen::Matrix3Xd source = RandomPoints(100, 1).colwise() + Eigen::Vector3d(1e6, -1e6, 1e6);
  const Similarity truth = MakeSimilarity(0.9, 20, {1, 1, 0}, {-1e6, 0, 1e6});
  const auto T = FitSimilarity(source, truth.Apply(source), ScaleMode::kFree);
  ASSERT_THAT(T, IsOk());
  EXPECT_NEAR(T->scale, 0.9, 1e-10);
  EXPECT_LT(DegreesBetween(T->rotation, truth.rotation), 1e-6);
}

TEST(FitSimilarity, KeepsScaleOneIfScaleIsOff) {
  const Eigen::Matrix3Xd source = RandomPoints(100, 1);
  const Similarity truth = MakeSimilarity(1.3, 77, {1, -2, 0.5}, {10, -20, 3});
  const auto T = FitSimilarity(source, truth.Apply(source), ScaleMode::kOff);
  ASSERT_THAT(T, IsOk());
  EXPECT_EQ(T->scale, 1);
  EXPECT_TRUE(T->rotation.isApprox(truth.rotation, kRounding));
}

TEST(FitSimilarity, RecoversAKnownPoseWithTheSymmetricScale) {
  const Eigen::Matrix3Xd source = RandomPoints(100, 1);
  const Similarity truth = MakeSimilarity(1.3, 77, {1, -2, 0.5}, {10, -200, 3});
  const auto T = FitSimilarity(source, truth.Apply(source), ScaleMode::kSymmetric);
  ASSERT_THAT(T, IsOk());
  EXPECT_NEAR(T->scale, 1.3, kRounding);
  EXPECT_TRUE(T->translation.isApprox(truth.translation, kRounding));
}

TEST(FitSimilarity, GivesTheInverseIfSourceAndTargetOfTheSymmetricScaleSwap) {
  const Eigen::Matrix3Xd source = RandomPoints(30, 1);
  const Eigen::Matrix3Xd target = source + 0.3 * RandomPoints(30, 2);
  const auto there = FitSimilarity(source, target, ScaleMode::kSymmetric);
  const auto back = FitSimilarity(target, source, ScaleMode::kSymmetric);
  ASSERT_THAT(there, IsOk());
  ASSERT_THAT(back, IsOk());
  EXPECT_TRUE((*back * *there).Matrix().isApprox(Eigen::Matrix4d::Identity(), kRounding));
  // The least-squares scale shrinks both ways.
  EXPECT_LT(FitSimilarity(source, target, ScaleMode::kFree)->scale *
                FitSimilarity(target, source, ScaleMode::kFree)->scale,
            1);
}

TEST(FitSimilarity, NeverReflects) {
  const Eigen::Matrix3Xd source = RandomPoints(100, 1);
  Eigen::Matrix3Xd mirrored = source;
  mirrored.row(0) = -mirrored.row(0);
  const auto T = FitSimilarity(source, mirrored, ScaleMode::kFree);
  ASSERT_THAT(T, IsOk());
  EXPECT_NEAR(T->rotation.determinant(), 1, kRounding);
}

TEST(FitSimilarity, HasTheLeastSquaredErrorAround) {
  const Eigen::Matrix3Xd source = RandomPoints(30, 1);
  const Eigen::Matrix3Xd target = source + 0.3 * RandomPoints(30, 2);
  const auto best = FitSimilarity(source, target, ScaleMode::kFree);
  ASSERT_THAT(best, IsOk());
  const double least = SquaredError(*best, source, target);
  Random random(3);
  int better = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Similarity step = MakeSimilarity(
        1 + random.Uniform(-1e-3, 1e-3), random.Uniform(-0.1, 0.1),
        {random.Normal(), random.Normal(), random.Normal()},
        {random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1)});
    better += SquaredError(step * *best, source, target) < least ? 1 : 0;
  }
  EXPECT_EQ(better, 0);
}

TEST(FitSimilarity, RefusesUnpairedOrTooFewPoints) {
  EXPECT_THAT(FitSimilarity(RandomPoints(5, 1), RandomPoints(4, 1), ScaleMode::kFree),
              StatusIs(absl::StatusCode::kInvalidArgument, "5 and 4"));
  EXPECT_THAT(FitSimilarity(RandomPoints(2, 1), RandomPoints(2, 1), ScaleMode::kFree),
              StatusIs(absl::StatusCode::kInvalidArgument, ">= 3"));
}

TEST(FitSimilarity, RefusesPointsThatCoincide) {
  const Eigen::Matrix3Xd source = Eigen::Vector3d(0.1, 77.7, -1e5).replicate(1, 7);
  EXPECT_THAT(FitSimilarity(source, RandomPoints(7, 1), ScaleMode::kOff),
              StatusIs(absl::StatusCode::kFailedPrecondition, "coincide"));
}

TEST(FitSimilarity, RefusesAScaleThatIsNotPositive) {
  const Eigen::Matrix3Xd target = Eigen::Matrix3Xd::Zero(3, 7);
  EXPECT_THAT(FitSimilarity(RandomPoints(7, 1), target, ScaleMode::kFree),
              StatusIs(absl::StatusCode::kFailedPrecondition, "scale"));
}

TEST(Similarity, InverseUndoesIt) {
  const Similarity T = MakeSimilarity(1.7, 40, {1, 2, 3}, {4, 5, 6});
  const Eigen::Matrix3Xd points = RandomPoints(10, 1);
  EXPECT_TRUE(T.Inverse().Apply(T.Apply(points)).isApprox(points, kRounding));
  EXPECT_TRUE((T * T.Inverse()).Matrix().isApprox(Eigen::Matrix4d::Identity(), kRounding));
}

TEST(Similarity, ProductAppliesTheRightFactorFirst) {
  const Similarity T_b_a = MakeSimilarity(1.7, 40, {1, 2, 3}, {4, 5, 6});
  const Similarity T_c_b = MakeSimilarity(0.6, -70, {0, 2, -1}, {-7, 8, 9});
  const Eigen::Matrix3Xd points = RandomPoints(10, 1);
  EXPECT_TRUE((T_c_b * T_b_a).Apply(points).isApprox(T_c_b.Apply(T_b_a.Apply(points)), kRounding));
  EXPECT_TRUE((T_c_b * T_b_a).Matrix().isApprox(T_c_b.Matrix() * T_b_a.Matrix(), kRounding));
}

TEST(Similarity, MatrixActsOnHomogeneousPoints) {
  const Similarity T = MakeSimilarity(1.7, 40, {1, 2, 3}, {4, 5, 6});
  const Eigen::Vector3d point(3, -1, 2);
  const Eigen::Vector4d moved = T.Matrix() * point.homogeneous();
  EXPECT_TRUE(moved.hnormalized().isApprox(T.ApplyToPoint(point), kRounding));
  EXPECT_EQ(moved(3), 1);
}

}  // namespace
}  // namespace cohort
