#include "common/geometry/synthetic/triangulate_patch.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace cohort {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A bowl-shaped disc of radius 50.
SurfacePatch Bowl() {
  SurfacePatch patch;
  patch.point = [](const Eigen::Vector2d& uv) {
    return Eigen::Vector3d(uv.x(), uv.y(), 0.02 * uv.squaredNorm());
  };
  patch.border = [](double t) {
    return Eigen::Vector2d(50.0 * std::cos(2 * kPi * t), 50.0 * std::sin(2 * kPi * t));
  };
  patch.edge_length = [](const Eigen::Vector2d&) { return 1.0; };
  return patch;
}

TEST(TriangulatePatch, HasExactlyTheVerticesAskedFor) {
  EXPECT_EQ(TriangulatePatch(Bowl(), 64, 1).VertexCount(), 64);
  EXPECT_EQ(TriangulatePatch(Bowl(), 1001, 1).VertexCount(), 1001);
}

TEST(TriangulatePatch, IsAnOrientedManifoldDisc) {
  const TriangleMesh mesh = TriangulatePatch(Bowl(), 2000, 3);
  std::map<std::pair<int, int>, int> directed;
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    for (int k = 0; k < 3; ++k) {
      ++directed[{mesh.faces(k, f), mesh.faces((k + 1) % 3, f)}];
    }
  }
  int64_t edges = 0;
  for (const auto& [edge, uses] : directed) {
    ASSERT_EQ(uses, 1);
    edges += directed.count({edge.second, edge.first}) == 0 || edge.first < edge.second ? 1 : 0;
  }
  EXPECT_EQ(mesh.VertexCount() - edges + mesh.FaceCount(), 1);  // Euler: a disc
}

TEST(TriangulatePatch, CoversTheSurfaceOnceFacingOutwards) {
  const TriangleMesh mesh = TriangulatePatch(Bowl(), 4000, 4);
  double projected = 0;
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.faces(1, f));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.faces(2, f));
    const double area = 0.5 * (b - a).cross(c - a).z();
    ASSERT_GT(area, 0.0);
    projected += area;
  }
  // The polygon of the border loses a sliver of the circle.
  EXPECT_NEAR(projected, kPi * 2500, 0.005 * kPi * 2500);
}

TEST(TriangulatePatch, HasNoThinTriangles) {
  const TriangleMesh mesh = TriangulatePatch(Bowl(), 4000, 5);
  double smallest = 1;
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    smallest = std::min(smallest, SineOfSmallestAngle(mesh.vertices.col(mesh.faces(0, f)),
                                                      mesh.vertices.col(mesh.faces(1, f)),
                                                      mesh.vertices.col(mesh.faces(2, f))));
  }
  EXPECT_GT(smallest, std::sin(20.0 * kPi / 180.0));
}

TEST(TriangulatePatch, IsFinerWhereShorterEdgesAreWanted) {
  SurfacePatch patch = Bowl();
  patch.edge_length = [](const Eigen::Vector2d& uv) { return uv.x() > 0 ? 1.0 : 2.0; };
  const TriangleMesh mesh = TriangulatePatch(patch, 3000, 6);
  const auto fine = (mesh.vertices.row(0).array() > 0).count();
  EXPECT_NEAR(static_cast<double>(fine) / 3000.0, 0.8, 0.05);  // 4 : 1
}

TEST(TriangulatePatch, AnotherSeedGivesAnotherMesh) {
  const TriangleMesh one = TriangulatePatch(Bowl(), 500, 1);
  EXPECT_EQ(one.vertices, TriangulatePatch(Bowl(), 500, 1).vertices);
  EXPECT_NE(one.vertices, TriangulatePatch(Bowl(), 500, 2).vertices);
}

TEST(SineOfSmallestAngle, AgreesWithKnownTriangles) {
  const Eigen::Vector3d o(0, 0, 0);
  EXPECT_NEAR(SineOfSmallestAngle(o, {1, 0, 0}, {0, 1, 0}), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(SineOfSmallestAngle(o, {2, 0, 0}, {1, std::sqrt(3.0), 0}), std::sqrt(0.75), 1e-15);
  EXPECT_EQ(SineOfSmallestAngle(o, {1, 0, 0}, {2, 0, 0}), 0.0);
  EXPECT_EQ(SineOfSmallestAngle(o, o, {2, 0, 0}), 0.0);
}

}  // namespace
}  // namespace cohort
