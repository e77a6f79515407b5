#include "common/geometry/registration/mirror.h"

#include <gtest/gtest.h>
#include <cmath>

#include <Eigen/LU>

#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/vertex_normals.h"
#include "common/geometry/nearest/surface_search.h"
#include "common/geometry/synthetic/capture.h"
#include "common/geometry/synthetic/procedural_face.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using testing::IsOk;
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

TEST(SymmetrizeMesh, LeavesASymmetricMeshAsItIs) {
  const TriangleMesh mesh = SymmetricSurface();
  const TriangleMesh symmetrized = SymmetrizeMesh(mesh, Similarity(), Correspondence::kVertex).mesh;
  EXPECT_LT((symmetrized.vertices - mesh.vertices).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(symmetrized.faces, mesh.faces);
}

TEST(SymmetrizeMesh, HalvesAnAsymmetryThatStaysOnItsSide) {
  TriangleMesh mesh = SymmetricSurface();
  const TriangleMesh even = mesh;
  const Eigen::Index left = 4 * 21 + 10;
  const Eigen::Index right = 16 * 21 + 10;
  mesh.vertices(2, left) += 2;
  const TriangleMesh symmetrized = SymmetrizeMesh(mesh, Similarity(), Correspondence::kVertex).mesh;
  EXPECT_NEAR(symmetrized.vertices(2, left), even.vertices(2, left) + 1, 1e-9);
  EXPECT_NEAR(symmetrized.vertices(2, right), even.vertices(2, right) + 1, 1e-9);
}

TEST(SymmetrizeMesh, GoesByTheAlignmentWhereverTheMeshLies) {
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
  const TriangleMesh symmetrized =
      SymmetrizeMesh(turned, T_mesh_mirrored, Correspondence::kVertex).mesh;
  EXPECT_LT((symmetrized.vertices - turned.vertices).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(SymmetrizeMesh, MovesNothingOnASymmetricSurfaceEither) {
  const TriangleMesh mesh = SymmetricSurface();
  const SymmetricMesh symmetric = SymmetrizeMesh(mesh, Similarity(), Correspondence::kSurface);
  // The search is in float32, about the centroid.
  EXPECT_LT((symmetric.mesh.vertices - mesh.vertices).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT(symmetric.asymmetry, 1e-5);
}

TEST(SymmetrizeMesh, MeasuresHowFarTheInnerVerticesMoved) {
  TriangleMesh mesh = SymmetricSurface();
  mesh.vertices(2, 4 * 21 + 10) += 2;  // One vertex: it and its partner move by 1.
  const double inner = 19 * 19;
  EXPECT_NEAR(SymmetrizeMesh(mesh, Similarity(), Correspondence::kVertex).asymmetry,
              std::sqrt(2 / inner), 1e-6);
}

TEST(SymmetrizeMesh, DoesNotCountWhereOneSideIsCutShorter) {
  // Without the three outermost columns of one side.
  TriangleMesh mesh = BumpySurface(21);
  TriangleMesh cut = SymmetricSurface();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    if (mesh.faces.col(f).minCoeff() >= 3 * 21) {
      kept.push_back(f);
    }
  }
  cut.faces = (mesh.faces(Eigen::all, kept).array() - 3 * 21).matrix();
  cut.vertices = Eigen::Matrix3Xd(SymmetricSurface().vertices.rightCols(18 * 21));
  // Mirrored in x = 12, the plane of symmetry, not in the centroid's.
  Similarity T_mesh_mirrored;
  T_mesh_mirrored.translation.x() = 2 * (12 - CentroidOf(cut.vertices).x());
  EXPECT_LT(SymmetrizeMesh(cut, T_mesh_mirrored, Correspondence::kSurface).asymmetry, 1e-5);
}

/// A face in any pose with all its asymmetry in one parameter, mm.
TriangleMesh FaceWithAsymmetry(double asymmetry, uint64_t seed, double max_rotation_degrees) {
  FaceParameters parameters = DrawPerson(seed, 1);
  parameters.identity.asymmetry = asymmetry;
  parameters.bumps = {};
  TriangleMesh mesh =
      CaptureFace(ProceduralFace(parameters), seed, {.vertices = 4000, .noise = 0.02, .warp = 0});
  const CapturePose pose = DrawPose(seed, {.max_rotation_degrees = max_rotation_degrees});
  mesh.vertices = pose.T_file_canonical.Apply(mesh.vertices);
  return mesh;
}

TEST(MakeSymmetric, TellsAsymmetricFacesFromSymmetricOnes) {
  PacketSearch search;
  const auto even = MakeSymmetric(FaceWithAsymmetry(0, 3, 10), {}, search);
  const auto odd = MakeSymmetric(FaceWithAsymmetry(4, 3, 10), {}, search);
  ASSERT_THAT(even, IsOk());
  ASSERT_THAT(odd, IsOk());
  EXPECT_LT(even->asymmetry, 0.08);  // Noise and triangles of about 2 mm.
  EXPECT_GT(odd->asymmetry, 4 * even->asymmetry);
}

TEST(MakeSymmetric, LeavesLittleAsymmetry) {
  PacketSearch search;
  const TriangleMesh face = FaceWithAsymmetry(4, 5, 10);
  const auto once = MakeSymmetric(face, {}, search);
  ASSERT_THAT(once, IsOk());
  const auto twice = MakeSymmetric(once->mesh, {}, search);
  ASSERT_THAT(twice, IsOk());
  EXPECT_LT(twice->asymmetry, once->asymmetry / 5);
  EXPECT_EQ(once->mesh.faces, face.faces);
}

TEST(MakeSymmetric, DoesNotDependOnThePose) {
  PacketSearch search;
  const auto upright = MakeSymmetric(FaceWithAsymmetry(4, 6, 0), {}, search);
  const auto turned = MakeSymmetric(FaceWithAsymmetry(4, 6, 180), {}, search);
  ASSERT_THAT(upright, IsOk());
  ASSERT_THAT(turned, IsOk());
  EXPECT_NEAR(turned->asymmetry, upright->asymmetry, 0.03 * upright->asymmetry);
}

TEST(MakeSymmetric, TakesPointClouds) {
  PacketSearch search;
  TriangleMesh cloud = FaceWithAsymmetry(4, 7, 10);
  cloud.faces.resize(3, 0);
  const auto symmetric = MakeSymmetric(cloud, {}, search);
  ASSERT_THAT(symmetric, IsOk());
  EXPECT_TRUE(symmetric->mesh.IsPointCloud());
}

TEST(MakeSymmetric, RefusesAMeshWithoutExtent) {
  PacketSearch search;
  TriangleMesh point;
  point.vertices = Eigen::Matrix3Xd::Constant(3, 5, 1);
  EXPECT_THAT(MakeSymmetric(point, {}, search),
              testing::StatusIs(absl::StatusCode::kFailedPrecondition, "extent"));
}

}  // namespace
}  // namespace cohort
