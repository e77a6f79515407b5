#include "common/geometry/mesh/bounds.h"

#include <cmath>

#include <gtest/gtest.h>

namespace cohort {
namespace {

constexpr double kRounding = 1e-12;

Eigen::Matrix3Xd CubeCorners() {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i) {
    corners.col(i) << 10 + 2 * (i & 1), 20 + 2 * ((i >> 1) & 1), -30 + 2 * ((i >> 2) & 1);
  }
  return corners;
}

TEST(Bounds, OfACubeAreItsCorners) {
  const Bounds bounds = BoundsOf(CubeCorners());
  EXPECT_EQ(bounds.low, Eigen::Vector3d(10, 20, -30));
  EXPECT_EQ(bounds.high, Eigen::Vector3d(12, 22, -28));
  EXPECT_EQ(bounds.Center(), Eigen::Vector3d(11, 21, -29));
  EXPECT_NEAR(bounds.Diagonal(), 2 * std::sqrt(3.0), kRounding);
}

TEST(Bounds, OfOnePointHaveNoDiagonal) {
  const Bounds bounds = BoundsOf(Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(bounds.low, bounds.high);
  EXPECT_EQ(bounds.Diagonal(), 0);
}

TEST(CentroidOf, ACubeIsItsCenter) {
  EXPECT_EQ(CentroidOf(CubeCorners()), Eigen::Vector3d(11, 21, -29));
}

TEST(RmsRadius, OfACubeIsHalfItsDiagonal) {
  EXPECT_NEAR(RmsRadius(CubeCorners()), std::sqrt(3.0), kRounding);
}

TEST(RmsRadius, DoesNotChangeWithThePosition) {
  const Eigen::Matrix3Xd moved = CubeCorners().colwise() + Eigen::Vector3d(512, -256, 1024);
  EXPECT_NEAR(RmsRadius(moved), RmsRadius(CubeCorners()), kRounding);
}

}  // namespace
}  // namespace cohort
