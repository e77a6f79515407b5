#include "client/evaluation/shapes.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/geometry/synthetic/demo_cohort.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;

TriangleMesh Face(int person) {
  DemoOptions options;
  options.vertices = 600;
  return MakeDemoScan(options, person, 0).value().mesh;
}

TEST(RankCorrelation, IsThatOfTheRanks) {
  const std::vector<double> a = {1, 2, 3, 4, 5};
  EXPECT_DOUBLE_EQ(RankCorrelation(a, std::vector<double>{1, 8, 27, 64, 125}), 1);
  EXPECT_DOUBLE_EQ(RankCorrelation(a, std::vector<double>{5, 4, 3, 2, 1}), -1);
  // 1 - 6 sum d^2 / (n (n^2 - 1)) with d = 1, 1, 0, 1, 1.
  EXPECT_DOUBLE_EQ(RankCorrelation(a, std::vector<double>{2, 1, 3, 5, 4}), 0.8);
  EXPECT_TRUE(std::isnan(RankCorrelation(a, std::vector<double>(5, 7.0))));
}

TEST(RankCorrelation, GivesTiesTheirMeanRank) {
  // Ranks 0.5, 0.5, 2, 3 against 0, 1, 2, 3: covariance 4.5, variances 4.5 and 5.
  EXPECT_NEAR(RankCorrelation(std::vector<double>{1, 1, 2, 3}, std::vector<double>{1, 2, 3, 4}),
              4.5 / std::sqrt(4.5 * 5), 1e-12);
}

TEST(TopTenthOverlap, CountsPositionsInCommon) {
  std::vector<double> a(20);
  std::vector<double> b(20);
  for (size_t i = 0; i < 20; ++i) {
    a[i] = b[i] = static_cast<double>(i);
  }
  EXPECT_DOUBLE_EQ(TopTenthOverlap(a, b), 1);
  b[19] = -1;
  EXPECT_DOUBLE_EQ(TopTenthOverlap(a, b), 0.5);
}

TEST(ShapeDistance, IsZeroForOneShapeAndTheSameBothWays) {
  const TriangleMesh a = Face(0);
  const TriangleMesh b = Face(1);
  EXPECT_EQ(ShapeDistance(a, a), 0);
  EXPECT_NEAR(ShapeDistance(a, b), ShapeDistance(b, a), 1e-4);
}

TEST(MovedOnto, BringsATurnedCopyBack) {
  const TriangleMesh face = Face(0);
  TriangleMesh turned = face;
  turned.vertices =
      Eigen::AngleAxisd(1, Eigen::Vector3d::UnitY()).toRotationMatrix() * face.vertices;
  const auto back = MovedOnto(turned, face);
  ASSERT_THAT(back, IsOk());
  EXPECT_LT((back->vertices - face.vertices).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(ValuesAt, AreThoseOfTheNearestVertex) {
  VariationMap map{.shape = Face(0), .rms = {}};
  for (Eigen::Index i = 0; i < map.shape.vertices.cols(); ++i) {
    map.rms.push_back(static_cast<double>(i));
  }
  EXPECT_EQ(ValuesAt(map, map.shape), map.rms);
}

}  // namespace
}  // namespace cohort
