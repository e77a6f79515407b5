#include "common/geometry/registration/coarse_pose.h"

#include <gtest/gtest.h>

#include "common/geometry/registration/scaling_icp.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/bits.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::BitsOf;
using testing::BumpySurface;
using testing::CutHole;
using testing::DegreesBetween;
using testing::IsOk;
using testing::StatusIs;

constexpr int kRows = 50;
/// What ICP mends easily; sampled points of two triangulations give no more.
constexpr double kCoarseDegrees = 5;

Similarity RandomMotion(uint64_t seed) {
  Random random(seed);
  Similarity motion;
  motion.rotation = testing::RandomRotation(random);
  motion.translation << random.Uniform(-500, 500), random.Uniform(-500, 500),
      random.Uniform(-500, 500);
  return motion;
}

TriangleMesh Moved(TriangleMesh mesh, const Similarity& motion) {
  mesh.vertices = motion.Apply(mesh.vertices);
  return mesh;
}

/// Angle between the found rotation and the one that undoes `motion`.
double CoarseError(const TriangleMesh& source,
                   const TriangleMesh& target,
                   const Similarity& motion) {
  const absl::StatusOr<CoarsePose> pose = FindCoarsePose(Moved(source, motion), target);
  EXPECT_THAT(pose, IsOk());
  return pose.ok() ? DegreesBetween(pose->T_target_source.rotation, motion.Inverse().rotation)
                   : 180;
}

class CoarsePoseFromAnywhere : public ::testing::TestWithParam<uint64_t> {};

TEST_P(CoarsePoseFromAnywhere, FindsAnotherScanOfTheShape) {
  EXPECT_LT(CoarseError(BumpySurface(kRows, 2, 3), BumpySurface(kRows), RandomMotion(GetParam())),
            kCoarseDegrees);
}

TEST_P(CoarsePoseFromAnywhere, FindsAScanWithHolesSpikesAndFloatingPieces) {
  TriangleMesh source = BumpySurface(kRows, 2, 3);
  CutHole({40, 60, 20}, 30, source);   // forehead
  CutHole({-70, -90, 0}, 40, source);  // corner
  CutHole({10, -50, 40}, 12, source);
  source.vertices.col(1300) *= 2;  // spikes
  source.vertices.col(700) *= 1.7;
  const TriangleMesh piece = BumpySurface(6, 5);
  const auto offset = static_cast<int32_t>(source.vertices.cols());
  source.vertices.conservativeResize(Eigen::NoChange, offset + piece.vertices.cols());
  source.vertices.rightCols(piece.vertices.cols()) =
      (0.15 * piece.vertices).colwise() + Eigen::Vector3d(90, 40, -60);
  source.faces.conservativeResize(Eigen::NoChange, source.faces.cols() + piece.faces.cols());
  source.faces.rightCols(piece.faces.cols()) = piece.faces.array() + offset;
  EXPECT_LT(CoarseError(source, BumpySurface(kRows), RandomMotion(GetParam())), 2 * kCoarseDegrees);
}

TEST_P(CoarsePoseFromAnywhere, LeadsIcpToTheAlignmentOfTheUnturnedMesh) {
  const TriangleMesh source = BumpySurface(kRows, 2, 3);
  const TriangleMesh target_mesh = BumpySurface(kRows);
  const IcpMesh target(target_mesh.vertices);
  PacketSearch search;
  const Similarity motion = RandomMotion(GetParam());
  const auto AlignedRotation = [&](const TriangleMesh& mesh) {
    const CoarsePose pose = FindCoarsePose(mesh, target_mesh).value();
    return AlignByIcp(IcpMesh(mesh.vertices), target, pose.T_target_source, {}, search)
        ->T_target_source.rotation;
  };
  EXPECT_LT(DegreesBetween(AlignedRotation(Moved(source, motion)) * motion.rotation,
                           AlignedRotation(source)),
            0.5);
}

INSTANTIATE_TEST_SUITE_P(RandomMotions, CoarsePoseFromAnywhere, ::testing::Range<uint64_t>(0, 6));

TEST(FindCoarsePose, WorksOnPointClouds) {
  TriangleMesh source = BumpySurface(kRows, 2, 3);
  TriangleMesh target = BumpySurface(kRows);
  source.faces.resize(3, 0);
  target.faces.resize(3, 0);
  EXPECT_LT(CoarseError(source, target, RandomMotion(9)), kCoarseDegrees);
}

TEST(FindCoarsePose, FindsAPartOnTheWhole) {
  TriangleMesh part = BumpySurface(kRows, 2);
  CutHole({-70, 0, 0}, 60, part);
  EXPECT_LT(CoarseError(part, BumpySurface(kRows), RandomMotion(9)), 2 * kCoarseDegrees);
}

TEST(FindCoarsePose, IsRigidAndMovesTheMeshOntoTheTarget) {
  const TriangleMesh target = BumpySurface(kRows);
  const TriangleMesh source = Moved(BumpySurface(kRows, 2), RandomMotion(1));
  const auto pose = FindCoarsePose(source, target);
  ASSERT_THAT(pose, IsOk());
  EXPECT_EQ(pose->T_target_source.scale, 1);
  EXPECT_GT(pose->lookups, 0);
  EXPECT_GT(pose->score, 0);
  const Eigen::Vector3d offset = pose->T_target_source.Apply(source.vertices).rowwise().mean() -
                                 target.vertices.rowwise().mean();
  EXPECT_LT(offset.norm(), 5);
}

TEST(FindCoarsePose, GivesTheSameBytesAgain) {
  const TriangleMesh target_mesh = BumpySurface(30);
  const TriangleMesh source = Moved(BumpySurface(30, 2), RandomMotion(2));
  const Eigen::Matrix4d a = FindCoarsePose(source, target_mesh)->T_target_source.Matrix();
  const Eigen::Matrix4d b = FindCoarsePose(source, target_mesh)->T_target_source.Matrix();
  EXPECT_EQ(BitsOf(a), BitsOf(b));
}

TEST(FindCoarsePose, WorksOnTheSmallestMesh) {
  TriangleMesh triangle;
  triangle.vertices.resize(3, 3);
  triangle.vertices << 0, 1, 0, 0, 0, 2, 5, 5, 5;
  triangle.faces.resize(3, 1);
  triangle.faces << 0, 1, 2;
  EXPECT_THAT(FindCoarsePose(triangle, triangle), IsOk());
  triangle.faces.resize(3, 0);
  EXPECT_THAT(FindCoarsePose(triangle, triangle), IsOk());
}

TEST(FindCoarsePose, RefusesAMeshWithoutExtent) {
  const TriangleMesh mesh = BumpySurface(20);
  TriangleMesh point;
  point.vertices = Eigen::Vector3d(0.1, 0.2, 0.3).replicate(1, 5);
  point.faces.resize(3, 0);
  EXPECT_THAT(FindCoarsePose(point, mesh),
              StatusIs(absl::StatusCode::kFailedPrecondition, "extent"));
  EXPECT_THAT(FindCoarsePose(mesh, point),
              StatusIs(absl::StatusCode::kFailedPrecondition, "extent"));
}

}  // namespace
}  // namespace cohort
