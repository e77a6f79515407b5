#include "common/geometry/nearest/point_cloud_normals.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

Eigen::Matrix3Xd SpherePoints(Eigen::Index count, double radius, uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double x = random.Normal();
    const double y = random.Normal();
    const double z = random.Normal();
    points.col(i) = radius * Eigen::Vector3d(x, y, z).normalized();
  }
  return points;
}

/// An open shell that bulges towards +z, like a face.
Eigen::Matrix3Xd Shell(Eigen::Index count) {
  Random random(2);
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double x = random.Uniform(-70, 70);
    const double y = random.Uniform(-90, 90);
    points.col(i) << x, y, 60 - x * x / 120 - y * y / 250;
  }
  return points;
}

TEST(PointCloudNormals, OfASpherePointOutward) {
  const Eigen::Matrix3Xd points = SpherePoints(4000, 50, 1).colwise() + Eigen::Vector3d(9, -4, 200);
  const auto normals = PointCloudNormals(points, {});
  ASSERT_THAT(normals, IsOk());
  double least = 1;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d outward = (points.col(i) - Eigen::Vector3d(9, -4, 200)) / 50;
    least = std::min(least, normals->col(i).dot(outward));
    ASSERT_NEAR(normals->col(i).norm(), 1, 1e-12);
  }
  EXPECT_GT(least, std::cos(0.25));  // 12 random neighbours span a cap of some 0.1 rad
}

TEST(PointCloudNormals, OfAnOpenShellAllPointToItsConvexSide) {
  const auto normals = PointCloudNormals(Shell(5000), {});
  ASSERT_THAT(normals, IsOk());
  EXPECT_GT(normals->row(2).minCoeff(), 0);
}

TEST(PointCloudNormals, FollowAViewDirection) {
  PointCloudNormalsOptions options;
  options.view_direction = Eigen::Vector3d(0, 0.1, -1);
  const auto normals = PointCloudNormals(Shell(5000), options);
  ASSERT_THAT(normals, IsOk());
  EXPECT_LT(normals->row(2).maxCoeff(), 0);
}

TEST(PointCloudNormals, OfSeparatePiecesAreEachTurnedOutward) {
  Eigen::Matrix3Xd points(3, 4000);
  points << Shell(2000), (-Shell(2000)).colwise() + Eigen::Vector3d(0, 0, -300);
  const auto normals = PointCloudNormals(points, {});
  ASSERT_THAT(normals, IsOk());
  EXPECT_GT(normals->leftCols(2000).row(2).minCoeff(), 0);
  EXPECT_LT(normals->rightCols(2000).row(2).maxCoeff(), 0);
}

TEST(PointCloudNormals, OfAPlaneAreExactAndAgree) {
  Random random(4);
  Eigen::Matrix3Xd points(3, 300);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    points.col(i) << random.Uniform(-9, 9), random.Uniform(-9, 9), 5;
  }
  const auto normals = PointCloudNormals(points, {});
  ASSERT_THAT(normals, IsOk());
  // Neither side is outward: the largest component is made positive.
  EXPECT_GT(normals->row(2).minCoeff(), 1 - 1e-12);
}

TEST(PointCloudNormals, DoNotDependOnTheOrderOfThePoints) {
  const Eigen::Matrix3Xd points = Shell(1000);
  const Eigen::Matrix3Xd reversed = points.rowwise().reverse();
  const auto normals = PointCloudNormals(points, {});
  const auto of_reversed = PointCloudNormals(reversed, {});
  ASSERT_THAT(normals, IsOk());
  ASSERT_THAT(of_reversed, IsOk());
  EXPECT_TRUE(of_reversed->rowwise().reverse().isApprox(*normals, 1e-9));
}

TEST(PointCloudNormals, AreZeroWhereAllNeighboursCoincide) {
  Eigen::Matrix3Xd points = SpherePoints(60, 10, 1);
  points.leftCols(12).colwise() = Eigen::Vector3d(0, 0, 30);
  const auto normals = PointCloudNormals(points, {});
  ASSERT_THAT(normals, IsOk());
  EXPECT_TRUE(normals->leftCols(12).isZero(0));
  EXPECT_TRUE(normals->allFinite());
}

TEST(PointCloudNormals, RefuseWhatHasNoPlane) {
  EXPECT_THAT(PointCloudNormals(Eigen::Matrix3Xd::Zero(3, 2), {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 points"));
  PointCloudNormalsOptions options;
  options.neighbours = 2;
  EXPECT_THAT(PointCloudNormals(Shell(10), options),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 neighbours"));
  options.neighbours = 3;
  options.view_direction = Eigen::Vector3d::Zero();
  EXPECT_THAT(PointCloudNormals(Shell(10), options),
              StatusIs(absl::StatusCode::kInvalidArgument, "view direction"));
}

}  // namespace
}  // namespace cohort
