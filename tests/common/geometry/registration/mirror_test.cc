#include "common/geometry/registration/mirror.h"

#include <gtest/gtest.h>
#include <cmath>

#include <Eigen/LU>

#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/vertex_normals.h"
#include "tests/common/geometry/registration/bumpy_surface.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using testing::MakeSimilarity;

/// An even grid that is the same left and right of x = 12.
TriangleMesh SymmetricSurface() {
  TriangleMesh mesh = BumpySurface(21);
  for (int i = 0; i < 21; ++i) {
    for (int j = 0; j < 21; ++j) {
      const double u = 0.1 * (i - 10);
      const double v = 0.1 * (j - 10);
      mesh.vertices.col(Eigen::Index{i} * 21 + j) << 12 + 70 * u, 95 * v,
          45 * (1 - 0.6 * u * u - 0.5 * v * v) + 5 * std::sin(3 * v) * std::cos(4 * u);
    }
  }
  return mesh;
}

TEST(MirroredMesh, ReflectsInThePlaneThroughTheCentroid) {
  const TriangleMesh mesh = BumpySurface(12);
  const TriangleMesh mirrored = MirroredMesh(mesh);
  const double center = CentroidOf(mesh.vertices).x();
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    EXPECT_DOUBLE_EQ(mirrored.vertices(0, v), 2 * center - mesh.vertices(0, v));
  }
  EXPECT_EQ(mirrored.vertices.bottomRows(2), mesh.vertices.bottomRows(2));
}

TEST(MirroredMesh, KeepsTheOutsideOutside) {
  const TriangleMesh mesh = BumpySurface(12);
  Eigen::Matrix3Xd reflected_normals = VertexNormals(mesh);
  reflected_normals.row(0) *= -1;
  EXPECT_TRUE(VertexNormals(MirroredMesh(mesh)).isApprox(reflected_normals, 1e-12));
}

TEST(MirroredMesh, OfTheMirroredMeshIsTheMesh) {
  const TriangleMesh mesh = BumpySurface(12);
  const TriangleMesh twice = MirroredMesh(MirroredMesh(mesh));
  EXPECT_TRUE(twice.vertices.isApprox(mesh.vertices, 1e-14));
  EXPECT_EQ(twice.faces, mesh.faces);
}

TEST(MirroredMesh, WorksForAPointCloud) {
  TriangleMesh cloud = BumpySurface(4);
  cloud.faces.resize(3, 0);
  EXPECT_EQ(MirroredMesh(cloud).FaceCount(), 0);
}

TEST(SymmetrizedMesh, LeavesASymmetricMeshAsItIs) {
  const TriangleMesh mesh = SymmetricSurface();
  const TriangleMesh symmetrized = SymmetrizedMesh(mesh, Similarity());
  EXPECT_LT((symmetrized.vertices - mesh.vertices).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(symmetrized.faces, mesh.faces);
}

TEST(SymmetrizedMesh, HalvesAnAsymmetryThatStaysOnItsSide) {
  TriangleMesh mesh = SymmetricSurface();
  const TriangleMesh even = mesh;
  const Eigen::Index left = 4 * 21 + 10;
  const Eigen::Index right = 16 * 21 + 10;
  mesh.vertices(2, left) += 2;
  const TriangleMesh symmetrized = SymmetrizedMesh(mesh, Similarity());
  EXPECT_NEAR(symmetrized.vertices(2, left), even.vertices(2, left) + 1, 1e-9);
  EXPECT_NEAR(symmetrized.vertices(2, right), even.vertices(2, right) + 1, 1e-9);
}

TEST(SymmetrizedMesh, GoesByTheAlignmentWhereverTheMeshLies) {
  const TriangleMesh even = SymmetricSurface();
  const Similarity T_turned_even = MakeSimilarity(1, 50, {0.1, 1, 0.3}, {5, 6, 700});
  TriangleMesh turned = even;
  turned.vertices = T_turned_even.Apply(even.vertices);
  // Mirroring the even mesh maps it to itself; so what brings the mirrored turned mesh back is
  // T_turned_even * (even's mirror) * T_turned_even^-1 * (turned's mirror), a proper motion.
  const auto mirror_of = [](const TriangleMesh& mesh) {
    Eigen::Matrix4d mirror = Eigen::Matrix4d::Identity();
    mirror(0, 0) = -1;
    mirror(0, 3) = 2 * CentroidOf(mesh.vertices).x();
    return mirror;
  };
  const Eigen::Matrix4d motion = T_turned_even.Matrix() * mirror_of(even) *
                                 T_turned_even.Inverse().Matrix() * mirror_of(turned);
  Similarity T_mesh_mirrored;
  T_mesh_mirrored.rotation = motion.topLeftCorner<3, 3>();
  T_mesh_mirrored.translation = motion.topRightCorner<3, 1>();
  ASSERT_NEAR(T_mesh_mirrored.rotation.determinant(), 1, 1e-12);
  const TriangleMesh symmetrized = SymmetrizedMesh(turned, T_mesh_mirrored);
  EXPECT_LT((symmetrized.vertices - turned.vertices).cwiseAbs().maxCoeff(), 1e-10);
}

}  // namespace
}  // namespace cohort
