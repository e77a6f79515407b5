#include "common/geometry/comparison/signed_distances.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

/// Queries over, under and on the plane z = 0, all looking up.
struct Plane {
  Eigen::Matrix3Xf queries{3, 4};
  Eigen::Matrix3Xf normals{3, 4};
  Eigen::Matrix3Xf target{3, 2};
  std::vector<int32_t> nearest = {0, 1, 0, 1};
  std::vector<float> squares = {4, 9, 0, 1};

  Plane() {
    queries << 0, 5, 0, 6,  //
        0, 0, 0, 0,         //
        2, -3, 0, 0;
    normals << 0, 0, 0, 0,  //
        0, 0, 0, 0,         //
        1, 1, 1, 1;
    target << 0, 5,  //
        0, 0,        //
        0, 0;
  }
};

TEST(SignedDistances, ArePositiveInFrontOfTheTarget) {
  const Plane plane;
  const SignedField field =
      SignedDistances(plane.queries, plane.normals, plane.target, plane.nearest, plane.squares);
  EXPECT_THAT(field.distances, ElementsAre(2, -3, 0, 0));
}

TEST(SignedDistances, CountTheQueriesWithoutASide) {
  const Plane plane;
  const SignedField field =
      SignedDistances(plane.queries, plane.normals, plane.target, plane.nearest, plane.squares);
  EXPECT_EQ(field.undecided, 1);  // The last one lies 1 beside its neighbour, in its own plane.
}

TEST(SignedDistances, ChangeSignWithTheQuerysNormal) {
  const Plane plane;
  const SignedField field =
      SignedDistances(plane.queries, -plane.normals, plane.target, plane.nearest, plane.squares);
  EXPECT_THAT(field.distances, ElementsAre(-2, 3, 0, 0));
}

TEST(SignedDistances, DoNotDependOnTheLengthOfTheNormal) {
  const Plane plane;
  const SignedField field = SignedDistances(plane.queries, 1e-30F * plane.normals, plane.target,
                                            plane.nearest, plane.squares);
  EXPECT_THAT(field.distances, ElementsAre(2, -3, 0, 0));
}

TEST(SignedDistances, AreZeroWithoutANormal) {
  const Plane plane;
  const SignedField field =
      SignedDistances(plane.queries, 0 * plane.normals, plane.target, plane.nearest, plane.squares);
  EXPECT_THAT(field.distances, ::testing::Each(0));
  EXPECT_EQ(field.undecided, 3);
}

TEST(SignedDistances, OfSurfacePointsEqualThoseOfVerticesThere) {
  const Plane plane;
  Eigen::Matrix3Xf points(3, 4);
  for (Eigen::Index i = 0; i < 4; ++i) {
    points.col(i) = plane.target.col(plane.nearest.at(static_cast<size_t>(i)));
  }
  EXPECT_EQ(
      SignedDistances(plane.queries, plane.normals, points, plane.squares).distances,
      SignedDistances(plane.queries, plane.normals, plane.target, plane.nearest, plane.squares)
          .distances);
}

}  // namespace
}  // namespace cohort
