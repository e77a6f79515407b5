#include "common/report/render/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

TEST(FacingOf, AnOpenSheetLooksAlongItsNormal) {
  TriangleMesh sheet = testing::WavySheet(10);
  EXPECT_EQ(FacingOf(sheet).front, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(FacingOf(sheet).up, Eigen::Vector3d::UnitY());
  sheet.faces.row(1).swap(sheet.faces.row(2));
  EXPECT_EQ(FacingOf(sheet).front, Eigen::Vector3d(0, 0, -1));
}

TEST(FacingOf, AFaceAlongYHasItsTopAtZ) {
  TriangleMesh sheet = testing::WavySheet(10);
  // x, y, z -> x, -z, y: what looked along +z now looks along -y.
  const Eigen::Matrix3Xd points = sheet.vertices;
  sheet.vertices.row(1) = -points.row(2);
  sheet.vertices.row(2) = points.row(1);
  EXPECT_EQ(FacingOf(sheet).front, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(FacingOf(sheet).up, Eigen::Vector3d::UnitZ());
}

TEST(FacingOf, AClosedSurfaceAndACloudLookAlongZ) {
  TriangleMesh closed = testing::Tetrahedron();
  EXPECT_EQ(FacingOf(closed).front, Eigen::Vector3d::UnitZ());
  closed.faces.resize(3, 0);
  EXPECT_EQ(FacingOf(closed).front, Eigen::Vector3d::UnitZ());
}

TEST(FitCamera, TheFrontViewKeepsTheAxesAndFillsThePicture) {
  const TriangleMesh mesh = testing::Tetrahedron(100);
  const Camera camera = FitCamera(mesh.vertices, {}, View::kFront);
  EXPECT_TRUE(camera.R_camera_mesh.isApprox(Eigen::Matrix3d::Identity(), 1e-15));
  EXPECT_DOUBLE_EQ(camera.half_width, 52);
  EXPECT_DOUBLE_EQ(camera.half_height, 52);
  const Eigen::Matrix3Xd seen = camera.Project(mesh.vertices);
  EXPECT_NEAR(seen.row(0).minCoeff(), -1 / 1.04, 1e-12);
  EXPECT_NEAR(seen.row(0).maxCoeff(), 1 / 1.04, 1e-12);
}

TEST(FitCamera, TheLeftViewBringsTheLeftCheekNearer) {
  // A face that looks along +z with +y up has its own left at +x.
  const TriangleMesh mesh = testing::MakeMesh({{50, 0, 0}, {-50, 0, 0}, {0, 0, 40}}, {{0, 2, 1}});
  const Eigen::Matrix3Xd left =
      FitCamera(mesh.vertices, {}, View::kLeftThreeQuarter).Project(mesh.vertices);
  EXPECT_GT(left(2, 0), left(2, 1));
  EXPECT_LT(left(0, 2), (left(0, 0) + left(0, 1)) / 2);  // The nose points to the viewer's left.
  const Eigen::Matrix3Xd right =
      FitCamera(mesh.vertices, {}, View::kRightThreeQuarter).Project(mesh.vertices);
  EXPECT_LT(right(2, 0), right(2, 1));
}

TEST(FitCamera, EveryViewIsARotation) {
  const TriangleMesh mesh = testing::Tetrahedron(100);
  const Facing facing{-Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
  for (const View view : {View::kFront, View::kLeftThreeQuarter, View::kRightThreeQuarter}) {
    const Eigen::Matrix3d R = FitCamera(mesh.vertices, facing, view).R_camera_mesh;
    EXPECT_TRUE((R * R.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-14));
    EXPECT_NEAR(R.determinant(), 1, 1e-14);
  }
}

TEST(FitCamera, PointsAtOnePlaceStillHaveAPicture) {
  const Camera camera = FitCamera(Eigen::Matrix3Xd::Zero(3, 2), {}, View::kFront);
  EXPECT_TRUE(camera.Project(Eigen::Matrix3Xd::Zero(3, 2)).allFinite());
}

TEST(WithAspect, OnlyEverEnlarges) {
  Camera camera;
  camera.half_width = 2;
  camera.half_height = 1;
  EXPECT_EQ(WithAspect(camera, 1).half_height, 2);
  EXPECT_EQ(WithAspect(camera, 4).half_width, 4);
  EXPECT_EQ(WithAspect(camera, 4).half_height, 1);
}

}  // namespace
}  // namespace cohort
