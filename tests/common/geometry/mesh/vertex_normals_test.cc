#include "common/geometry/mesh/vertex_normals.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using testing::MakeMesh;
using testing::Tetrahedron;
using testing::WavySheet;

constexpr double kRounding = 1e-12;

TEST(VertexNormals, OfAFlatFacePointUp) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 5}, {10, 0, 5}, {0, 10, 5}}, {{0, 1, 2}});
  const Eigen::Matrix3Xd normals = VertexNormals(mesh);
  for (Eigen::Index v = 0; v < 3; ++v) {
    EXPECT_EQ(normals.col(v), Eigen::Vector3d(0, 0, 1)) << v;
  }
}

TEST(VertexNormals, WeighFacesByTheirArea) {
  // A face of area 2 that looks along +z and one of area 1 that looks along +x meet in vertex 0.
  const TriangleMesh mesh =
      MakeMesh({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 1, 0}, {0, 0, 2}}, {{0, 1, 2}, {0, 3, 4}});
  const Eigen::Vector3d expected = Eigen::Vector3d(1, 0, 2).normalized();
  EXPECT_NEAR((VertexNormals(mesh).col(0) - expected).norm(), 0, kRounding);
}

TEST(VertexNormals, OfATetrahedronPointOutward) {
  const TriangleMesh mesh = Tetrahedron();
  const Eigen::Matrix3Xd normals = VertexNormals(mesh);
  const Eigen::Vector3d center = mesh.vertices.rowwise().mean();
  for (Eigen::Index v = 0; v < 4; ++v) {
    EXPECT_GT(normals.col(v).dot(mesh.vertices.col(v) - center), 0) << v;
    EXPECT_NEAR(normals.col(v).norm(), 1, kRounding) << v;
  }
}

TEST(VertexNormals, TurnWithTheMesh) {
  TriangleMesh mesh = WavySheet(12);
  const Eigen::Matrix3Xd before = VertexNormals(mesh);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  mesh.vertices = R * mesh.vertices;
  EXPECT_NEAR((VertexNormals(mesh) - R * before).cwiseAbs().maxCoeff(), 0, kRounding);
}

TEST(VertexNormals, AreZeroWithoutAFaceThatHasArea) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {9, 9, 9}}, {{0, 1, 2}});
  EXPECT_TRUE(VertexNormals(mesh).isZero(0));
}

TEST(VertexNormals, OfTinyMeshesDoNotUnderflow) {
  const TriangleMesh mesh = Tetrahedron(1e-90);
  EXPECT_NEAR(VertexNormals(mesh).col(1).norm(), 1, kRounding);
}

}  // namespace
}  // namespace cohort
