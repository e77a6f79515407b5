#include "common/geometry/registration/fidentis_icp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <gmock/gmock.h>
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

FidentisAlignment Align(const Eigen::Matrix3Xf& source,
                        const Eigen::Matrix3Xf& target,
                        const FidentisIcpOptions& options) {
  absl::StatusOr<FidentisAlignment> alignment =
      AlignByFidentisIcp(source, *NearestVertex::Build(target), options);
  EXPECT_THAT(alignment, IsOk());
  return alignment.ok() ? *std::move(alignment) : FidentisAlignment();
}

Eigen::Matrix3Xf FirstPerson() {
  return FidentisCentered(BumpySurface(25).vertices);
}

/// Another one, turned and moved a little.
Eigen::Matrix3Xf SecondPerson() {
  return FidentisCentered(
      MakeSimilarity(1.02, 7, {1, -2, 3}, {3, -1, 2}).Apply(BumpySurface(25, 2, 3).vertices));
}

/// Eight corners of a box about `center`, 100 apart: near ones only where they are meant to be.
Eigen::Matrix3Xf Corners(const Eigen::Vector3f& center, const Eigen::Vector3f& half_size) {
  Eigen::Matrix3Xf corners(3, 8);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f sign(i % 2 == 0 ? -1.0F : 1.0F, i / 2 % 2 == 0 ? -1.0F : 1.0F,
                               i < 4 ? -1.0F : 1.0F);
    corners.col(i) = center + half_size.cwiseProduct(sign);
  }
  return corners;
}

FidentisIcpOptions WithScale() {
  FidentisIcpOptions options;
  options.scale = FidentisScale::kFromX;
  return options;
}

TEST(FidentisCentered, MovesTheMiddleOfTheBoxToTheOriginNotTheCentroid) {
  Eigen::Matrix3Xd vertices(3, 4);
  vertices << 0, 10, 10, 10,  //
      -4, 2, 2, 2,            //
      1, 1, 1, 7;
  EXPECT_EQ(FidentisCenter(vertices), Eigen::Vector3f(5, -1, 4));
  Eigen::Matrix3Xf expected(3, 4);
  expected << -5, 5, 5, 5,  //
      -3, 3, 3, 3,          //
      -3, -3, -3, 3;
  EXPECT_EQ(FidentisCentered(vertices), expected);
}

TEST(FidentisCentered, RoundsCoordinatesToFloatsFirst) {
  Eigen::Matrix3Xd vertices = Eigen::Matrix3Xd::Zero(3, 2);
  vertices(0, 0) = 1e8 + 1;  // 1e8 as a float
  EXPECT_EQ(FidentisCentered(vertices)(0, 0), 5e7F);
}

TEST(AlignByFidentisIcp, MakesOneStepMoreThanItsMaximum) {
  FidentisIcpOptions options = WithScale();
  options.tolerance = 0;
  options.max_iterations = 5;
  const FidentisAlignment alignment = Align(SecondPerson(), FirstPerson(), options);
  EXPECT_EQ(alignment.steps.size(), 6U);
  EXPECT_FALSE(alignment.converged);
  EXPECT_EQ(alignment.lookups, 6 * 625);
}

TEST(AlignByFidentisIcp, MakesTwoStepsAtLeast) {
  FidentisIcpOptions options = WithScale();
  options.tolerance = 1000;
  const FidentisAlignment alignment = Align(SecondPerson(), FirstPerson(), options);
  EXPECT_EQ(alignment.steps.size(), 2U);
  EXPECT_TRUE(alignment.converged);
}

TEST(AlignByFidentisIcp, LeavesAMeshOnItselfInTwoSteps) {
  FidentisIcpOptions options = WithScale();
  options.tolerance = 0;
  const FidentisAlignment alignment = Align(FirstPerson(), FirstPerson(), options);
  EXPECT_EQ(alignment.steps.size(), 2U);
  EXPECT_TRUE(alignment.converged);
  EXPECT_EQ(alignment.steps.back().mean_distance, 0);
  EXPECT_TRUE(alignment.moved.isApprox(FirstPerson(), 1e-6F));
}

TEST(AlignByFidentisIcp, StopsByTheDistancesBeforeTheLastTwoSteps) {
  FidentisIcpOptions options = WithScale();
  options.max_iterations = 60;
  const FidentisAlignment alignment = Align(SecondPerson(), FirstPerson(), options);
  ASSERT_TRUE(alignment.converged);
  std::vector<float> changes;
  for (size_t i = 1; i < alignment.steps.size(); ++i) {
    changes.push_back(
        std::abs(alignment.steps[i - 1].mean_distance - alignment.steps[i].mean_distance));
  }
  ASSERT_GE(changes.size(), 2U);
  EXPECT_LE(changes.back(), options.tolerance);
  EXPECT_GT(*std::min_element(changes.begin(), changes.end() - 1), options.tolerance);
}

TEST(AlignByFidentisIcp, ReportsTheMeanDistanceBeforeAStepAndTheMeanStep) {
  const Eigen::Matrix3Xf target = Corners(Eigen::Vector3f::Zero(), {50, 50, 50});
  const Eigen::Matrix3Xf source = target.colwise() - Eigen::Vector3f(2, -3, 6);
  const FidentisAlignment alignment = Align(source, target, {});
  EXPECT_EQ(alignment.steps[0].mean_distance, 7);
  EXPECT_EQ(alignment.steps[0].translation, Eigen::Vector3f(2, -3, 6));
  EXPECT_LE(alignment.steps[1].mean_distance, 1e-4F);
}

TEST(AlignByFidentisIcp, TakesTheScaleFromXAlone) {
  // 1.1 in x, 0.8 in y, 0.9 in z: eq. 3.9 would give the mean, 0.933.
  const Eigen::Matrix3Xf source = Corners(Eigen::Vector3f::Zero(), {50, 50, 50});
  const Eigen::Matrix3Xf target = Corners(Eigen::Vector3f::Zero(), {55, 40, 45});
  EXPECT_NEAR(Align(source, target, WithScale()).steps[0].scale, 1.1F, 1e-6F);
  EXPECT_EQ(Align(source, target, {}).steps[0].scale, 1);
}

TEST(AlignByFidentisIcp, ScalesAboutTheOriginWithTheTranslationOfBefore) {
  // The boxes share their middle, so the mean step is 0; yet the source leaves it.
  const Eigen::Vector3f center(10, 20, -30);
  const Eigen::Matrix3Xf source = Corners(center, {50, 50, 50});
  const Eigen::Matrix3Xf target = Corners(center, {55, 50, 50});
  FidentisIcpOptions options = WithScale();
  options.tolerance = 1000;
  const FidentisAlignment alignment = Align(source, target, options);
  EXPECT_LE(alignment.steps[0].translation.norm(), 1e-4F);
  // Step 0: times 1.1; step 1: the mean step back, and no more scale since x fits.
  EXPECT_NEAR(alignment.steps[1].scale, 1.0F, 1e-5F);
  EXPECT_TRUE(alignment.steps[1].translation.isApprox(-0.1F * center, 1e-4F));
}

TEST(AlignByFidentisIcp, TurnsAMeshBack) {
  const Similarity T = MakeSimilarity(1, 5, {3, 1, 2}, Eigen::Vector3d::Zero());
  const Eigen::Matrix3Xf turned = T.Apply(FirstPerson().cast<double>()).cast<float>();
  FidentisIcpOptions options;
  options.tolerance = 0;
  options.max_iterations = 60;
  const FidentisAlignment alignment = Align(turned, FirstPerson(), options);
  EXPECT_LE(DegreesBetween(alignment.T_target_source.rotation, T.Inverse().rotation), 1e-3);
  EXPECT_LE((alignment.moved - FirstPerson()).cwiseAbs().maxCoeff(), 1e-3F);
}

TEST(AlignByFidentisIcp, TellsTheStepsAsOneSimilarity) {
  const FidentisAlignment alignment = Align(SecondPerson(), FirstPerson(), WithScale());
  const Eigen::Matrix3Xd applied = alignment.T_target_source.Apply(SecondPerson().cast<double>());
  // 11 steps that round coordinates of 100 mm to 4e-6 mm, some of them several times.
  EXPECT_LE((applied - alignment.moved.cast<double>()).cwiseAbs().maxCoeff(), 2e-4);
}

TEST(AlignByFidentisIcp, GoesOnWhereTheLastAlignmentLeftTheMesh) {
  // 3 steps and 4 steps are 7 steps, to the last bit.
  FidentisIcpOptions options = WithScale();
  options.tolerance = 0;
  options.max_iterations = 2;
  const FidentisAlignment first = Align(SecondPerson(), FirstPerson(), options);
  options.max_iterations = 3;
  const FidentisAlignment second = Align(first.moved, FirstPerson(), options);
  options.max_iterations = 6;
  const FidentisAlignment both = Align(SecondPerson(), FirstPerson(), options);
  EXPECT_EQ(second.moved, both.moved);
  EXPECT_TRUE((second.T_target_source * first.T_target_source)
                  .Matrix()
                  .isApprox(both.T_target_source.Matrix(), 1e-12));
}

TEST(AlignByFidentisIcp, RefusesAMeshWithoutExtentAlongX) {
  Eigen::Matrix3Xf flat = FirstPerson();
  flat.row(0).setZero();
  const auto target = NearestVertex::Build(flat);
  EXPECT_THAT(AlignByFidentisIcp(flat, *target, WithScale()),
              StatusIs(absl::StatusCode::kFailedPrecondition, "step 0: scale"));
  EXPECT_THAT(AlignByFidentisIcp(flat, *target, {}), IsOk());
}

TEST(AlignByFidentisIcp, RefusesTwoVerticesAndBadOptions) {
  const Eigen::Matrix3Xf mesh = FirstPerson();
  const auto target = NearestVertex::Build(mesh);
  EXPECT_THAT(AlignByFidentisIcp(mesh.leftCols(2), *target, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "got 2"));
  FidentisIcpOptions options;
  options.max_iterations = 0;
  EXPECT_THAT(AlignByFidentisIcp(mesh, *target, options),
              StatusIs(absl::StatusCode::kInvalidArgument, "max_iterations is 0"));
  options = {};
  options.tolerance = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(options.Validate(), StatusIs(absl::StatusCode::kInvalidArgument, "tolerance is"));
}

}  // namespace
}  // namespace cohort
