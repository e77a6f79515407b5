#include "common/geometry/synthetic/procedural_face.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace cohort {
namespace {

/// The average face, neutral.
FaceParameters Average() {
  return DrawPerson(1, 0.0);
}

template <typename Function>
void OverTheMask(const Function& call) {
  for (int row = -38; row <= 34; ++row) {
    for (int column = -30; column <= 30; ++column) {
      call(2.5 * column, 2.5 * row);
    }
  }
}

TEST(DrawPerson, WithoutSpreadIsTheAverageFace) {
  const FaceParameters face = DrawPerson(5, 0.0);
  EXPECT_EQ(face.identity.nose_length, 0.0);
  EXPECT_EQ(face.identity.asymmetry, 0.0);
  EXPECT_EQ(face.bumps[3].offset.norm(), 0.0);
}

TEST(DrawPerson, IsTheSameForTheSameSeedOnly) {
  EXPECT_EQ(DrawPerson(5, 1.0).identity.jaw_width, DrawPerson(5, 1.0).identity.jaw_width);
  EXPECT_NE(DrawPerson(5, 1.0).identity.jaw_width, DrawPerson(6, 1.0).identity.jaw_width);
}

TEST(DrawExpression, StaysWithinItsStrength) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const FaceExpression e = DrawExpression(seed, 0.8);
    const std::vector<double> sizes = {e.smile,       e.mouth_open, e.brow_raise,
                                       e.brow_furrow, e.cheek_puff, e.pout};
    EXPECT_GE(*std::max_element(sizes.begin(), sizes.end()), 0.4) << seed;
    EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), 0.8) << seed;
    EXPECT_GE(*std::min_element(sizes.begin(), sizes.end()), 0.0) << seed;
  }
}

TEST(DescribeExpression, NamesWhatTheFaceDoes) {
  FaceExpression expression;
  EXPECT_EQ(DescribeExpression(expression), "neutral");
  expression.smile = 0.619;
  expression.pout = 0.05;
  EXPECT_EQ(DescribeExpression(expression), "smile 0.62 + pout 0.05");
  expression.smile = 1.0;
  EXPECT_EQ(DescribeExpression(expression), "smile 1.00 + pout 0.05");
}

TEST(ProceduralFace, LooksAlongZAndIsAsBigAsAFace) {
  const ProceduralFace face(Average());
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = -low;
  OverTheMask([&](double u, double v) {
    low = low.cwiseMin(face.Point(u, v));
    high = high.cwiseMax(face.Point(u, v));
  });
  EXPECT_GT(high.x() - low.x(), 115.0);  // 130-165 with the sides beyond this grid
  EXPECT_LT(high.x() - low.x(), 165.0);
  EXPECT_GT(high.y() - low.y(), 150.0);
  EXPECT_LT(high.y() - low.y(), 220.0);
  // The most forward point is the tip of the nose, in the middle.
  EXPECT_NEAR(face.Point(0, -8).z(), high.z(), 1.5);
}

TEST(ProceduralFace, IsSymmetricOnAverage) {
  const ProceduralFace face(Average());
  OverTheMask([&](double u, double v) {
    const Eigen::Vector3d left = face.Point(u, v);
    const Eigen::Vector3d right = face.Point(-u, v);
    ASSERT_NEAR(left.x(), -right.x(), 1e-9);
    ASSERT_NEAR(left.y(), right.y(), 1e-9);
    ASSERT_NEAR(left.z(), right.z(), 1e-9);
  });
}

TEST(ProceduralFace, HasNoJumps) {
  // The open mouth is the steepest place: 11 mm over 2 mm of v, half as much again in the middle,
  // and deeper. A jump would show as its height / h.
  FaceParameters open = Average();
  open.expression.mouth_open = 1.0;
  const ProceduralFace face(open);
  const double h = 1e-4;
  double steepest = 0;
  OverTheMask([&](double u, double v) {
    const Eigen::Vector3d p = face.Point(u, v);
    steepest = std::max(
        {steepest, (face.Point(u + h, v) - p).norm() / h, (face.Point(u, v + h) - p).norm() / h});
  });
  EXPECT_LT(steepest, 20.0);
}

TEST(ProceduralFace, EveryPartIsWhereItShouldBe) {
  const ProceduralFace face(Average());
  const auto z = [&](double u, double v) { return face.Point(u, v).z(); };
  EXPECT_GT(z(0, -8), z(0, 30) + 12) << "the nose tip stands out over its root";
  EXPECT_GT(z(0, 44), z(0, 90) + 10) << "the forehead curves back";
  EXPECT_GT(z(28, 44), z(28, 36) + 1) << "the brow stands out over the socket";
  EXPECT_GT(z(34, 29), z(20, 31)) << "the eyeball bulges in the socket";
  EXPECT_GT(z(0, -37), z(0, -41) + 1) << "the upper lip stands out over the mouth line";
  EXPECT_GT(z(0, -46), z(0, -41) + 1) << "so does the lower lip";
  EXPECT_GT(z(0, -71), z(0, -57) + 1) << "the chin stands out under its crease";
}

TEST(ProceduralFace, ExpressionsMoveTheirPartAndLeaveTheRest) {
  FaceParameters smiling = Average();
  smiling.expression.smile = 1.0;
  const ProceduralFace neutral(Average());
  const ProceduralFace smile(smiling);
  const Eigen::Vector3d corner = smile.Point(30, -41) - neutral.Point(30, -41);
  EXPECT_GT(corner.x(), 2.0);
  EXPECT_GT(corner.y(), 2.0);
  EXPECT_LT((smile.Point(0, 75) - neutral.Point(0, 75)).norm(), 0.05);
}

}  // namespace
}  // namespace cohort
