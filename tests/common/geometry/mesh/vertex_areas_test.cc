#include "common/geometry/mesh/vertex_areas.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using testing::MakeMesh;
using testing::Tetrahedron;
using testing::WavySheet;

constexpr double kRounding = 1e-12;

TEST(VertexAreas, AreThirdsOfTheFaces) {
  // Two faces of areas 2 and 1 share the first two vertices.
  const TriangleMesh mesh =
      MakeMesh({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 1}});
  const Eigen::VectorXd areas = VertexAreas(mesh);
  EXPECT_NEAR(areas[0], 1, kRounding);
  EXPECT_NEAR(areas[1], 1, kRounding);
  EXPECT_NEAR(areas[2], 2.0 / 3, kRounding);
  EXPECT_NEAR(areas[3], 1.0 / 3, kRounding);
}

TEST(VertexAreas, AddUpToTheSurface) {
  const double side = 100.0 * 100.0 / 2;
  EXPECT_NEAR(VertexAreas(Tetrahedron(100)).sum(), side * (3 + std::sqrt(3.0)), 1e-9);
}

TEST(VertexAreas, DoNotChangeWithThePose) {
  TriangleMesh mesh = WavySheet(9);
  const Eigen::VectorXd before = VertexAreas(mesh);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(3, 1, 2).normalized()).toRotationMatrix();
  mesh.vertices = (R * mesh.vertices).colwise() + Eigen::Vector3d(5, -7, 9);
  EXPECT_NEAR((VertexAreas(mesh) - before).cwiseAbs().maxCoeff(), 0, 1e-10);
}

TEST(VertexAreas, AreZeroWithoutFaces) {
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);
  EXPECT_EQ(VertexAreas(cloud).size(), 4);
  EXPECT_TRUE(VertexAreas(cloud).isZero(0));
}

}  // namespace
}  // namespace cohort
