// Jobs whose coarse pose comes from landmarks.
#include <cmath>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "common/geometry/io/write_mesh.h"
#include "common/geometry/synthetic/capture.h"
#include "common/geometry/synthetic/procedural_face.h"
#include "common/jobs/landmark_blob.h"
#include "common/store/memory_blob_store.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort {
namespace {

using testing::FinishedJob;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::Order;
using testing::RunJob;
using testing::StatusIs;

constexpr int kScans = 4;

/// Scans of one person in any pose, their landmarks, and where each lies.
struct Scans {
  std::vector<SetMesh> meshes;
  LandmarkTable landmarks;
  std::vector<Similarity> T_file_canonical;
};

LandmarkSet LandmarksOf(const ProceduralFace& face) {
  LandmarkSet set;
  const std::vector<std::pair<double, double>> places = {{0, 0},   {-30, 40},  {30, 40},
                                                         {0, -80}, {-40, -30}, {40, -30}};
  set.points.resize(3, static_cast<Eigen::Index>(places.size()));
  for (size_t i = 0; i < places.size(); ++i) {
    set.names.push_back(absl::StrCat("p", i));
    set.points.col(static_cast<Eigen::Index>(i)) = face.Point(places[i].first, places[i].second);
  }
  return set;
}

/// Stretches the face so that no axis is longer than another.
Eigen::Matrix3d Evener(const Eigen::Matrix3Xd& vertices) {
  const Eigen::Matrix3Xd centred = vertices.colwise() - vertices.rowwise().mean();
  const Eigen::Matrix3d covariance =
      centred * centred.transpose() / static_cast<double>(vertices.cols());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  return 40 * solver.operatorInverseSqrt();
}

enum class Axes { kAsTheyAre, kAllAlike };

Scans MakeScans(BlobStore& store, Axes axes) {
  const ProceduralFace face(DrawPerson(4, 1));
  const LandmarkSet landmarks = LandmarksOf(face);
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  Scans scans;
  for (int scan = 0; scan < kScans; ++scan) {
    const uint64_t seed = 10 + static_cast<uint64_t>(scan);
    TriangleMesh mesh = CaptureFace(face, seed, {.vertices = 1500, .noise = 0.02, .warp = 0});
    if (axes == Axes::kAllAlike && scan == 0) {
      stretch = Evener(mesh.vertices);
    }
    const Similarity T =
        DrawPose(seed, {.max_rotation_degrees = 180, .max_translation = 200, .scale_sd = 0.05})
            .T_file_canonical;
    mesh.vertices = T.Apply(stretch * mesh.vertices);
    const std::string bytes = WritePly(mesh);
    SetMesh put;
    put.name = absl::StrCat("scan", scan, ".ply");
    put.raw = *store.Put(bytes);
    put.size_bytes = static_cast<int64_t>(bytes.size());
    scans.landmarks[put.name] = {landmarks.names, T.Apply(stretch * landmarks.points)};
    scans.meshes.push_back(put);
    scans.T_file_canonical.push_back(T);
  }
  return scans;
}

JobSpec LandmarkSpec(BlobStore& store, const LandmarkTable& table) {
  JobSpec spec;
  spec.method = Method::kOne;
  spec.pose = PoseMode::kLandmarks;
  spec.landmarks = *store.Put(EncodeLandmarkBlob(table));
  return spec;
}

std::vector<MeshAlignment> Decoded(BlobStore& store, const std::vector<Digest>& blobs) {
  std::vector<MeshAlignment> all;
  for (const Digest& blob : blobs) {
    const std::vector<MeshAlignment> some = *DecodeAlignmentBlob(*store.Get(blob));
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

class LandmarkJobs : public ::testing::TestWithParam<Axes> {};

TEST_P(LandmarkJobs, RecoverAnyRotation) {
  MemoryBlobStore store;
  const Scans scans = MakeScans(store, GetParam());
  const FinishedJob job = RunJob(LandmarkSpec(store, scans.landmarks), scans.meshes, store);
  ASSERT_THAT(job.status, IsOk());
  const std::vector<MeshAlignment> alignments = Decoded(store, job.plan->Outputs().alignments);
  ASSERT_EQ(alignments.size(), size_t{kScans});
  for (const MeshAlignment& item : alignments) {
    const Similarity expected = scans.T_file_canonical[0] *
                                scans.T_file_canonical[static_cast<size_t>(item.mesh)].Inverse();
    const Similarity& found = item.alignment.T_target_source;
    const double degrees =
        Eigen::AngleAxisd(expected.rotation.transpose() * found.rotation).angle() * 180 / M_PI;
    EXPECT_LT(degrees, 1) << item.mesh;  // 1500 vertices: about 5 mm apart.
    EXPECT_NEAR(found.scale / expected.scale, 1, 0.01) << item.mesh;
  }
  for (const MeshAlignment& item : Decoded(store, job.plan->Outputs().poses)) {
    EXPECT_LT(item.alignment.rms_residual, 1e-9) << "landmarks of one person fit exactly";
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes,
                         LandmarkJobs,
                         ::testing::Values(Axes::kAsTheyAre, Axes::kAllAlike));

TEST(LandmarkPose, HasTheJobsScaleUnlessItIsOffOrLimited) {
  MemoryBlobStore store;
  const Scans scans = MakeScans(store, Axes::kAsTheyAre);
  JobSpec spec = LandmarkSpec(store, scans.landmarks);
  const auto scale_of_second = [&] {
    const FinishedJob job = RunJob(spec, scans.meshes, store);
    return Decoded(store, job.plan->Outputs().poses).at(1).alignment.T_target_source.scale;
  };
  const double truth = scans.T_file_canonical[0].scale / scans.T_file_canonical[1].scale;
  EXPECT_NEAR(scale_of_second(), truth, 1e-9);
  spec.icp.scale_mode = ScaleMode::kFree;
  EXPECT_NEAR(scale_of_second(), truth, 1e-9);
  spec.icp.scale_limit = 1.5;
  EXPECT_EQ(scale_of_second(), 1) << "the limit counts from the start of ICP";
  spec.icp.scale_limit = 0;
  spec.icp.scale_mode = ScaleMode::kOff;
  EXPECT_EQ(scale_of_second(), 1);
}

TEST(LandmarkPose, QuarantinesMeshesWhoseLandmarksCannotBeFitted) {
  MemoryBlobStore store;
  Scans scans = MakeScans(store, Axes::kAsTheyAre);
  scans.landmarks.erase("scan1.ply");
  LandmarkSet& on_a_line = scans.landmarks["scan2.ply"];
  for (Eigen::Index i = 0; i < on_a_line.Count(); ++i) {
    on_a_line.points.col(i) = Eigen::Vector3d(static_cast<double>(i), 0, 0);
  }
  const FinishedJob job = RunJob(LandmarkSpec(store, scans.landmarks), scans.meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_THAT(job.plan->Meshes()[1].rejection, HasSubstr("scan1.ply: no coarse pose: it has no"));
  EXPECT_THAT(job.plan->Meshes()[2].rejection, HasSubstr("of the source lie on one line"));
  EXPECT_EQ(testing::RmsOfPairs(job, store).size(), 4u);
}

TEST(LandmarkPose, FailsTheJobIfTheBaseHasNoLandmarks) {
  MemoryBlobStore store;
  Scans scans = MakeScans(store, Axes::kAsTheyAre);
  scans.landmarks.erase("scan0.ply");
  const FinishedJob job = RunJob(LandmarkSpec(store, scans.landmarks), scans.meshes, store);
  EXPECT_THAT(job.status, StatusIs(absl::StatusCode::kFailedPrecondition,
                                   "the base mesh scan0.ply has no landmarks"));
}

TEST(LandmarkPose, ServesTheChoiceOfTheBaseToo) {
  MemoryBlobStore store;
  const Scans scans = MakeScans(store, Axes::kAllAlike);
  JobSpec spec = LandmarkSpec(store, scans.landmarks);
  spec.base_rule = BaseRule::kAuto;
  const FinishedJob job = RunJob(spec, scans.meshes, store);
  ASSERT_THAT(job.status, IsOk());
  const auto choice = DecodeBaseBlob(*store.Get(job.plan->Outputs().base_choice));
  ASSERT_THAT(choice, IsOk());
  ASSERT_EQ(choice->candidates.size(), size_t{kScans});
  for (const BaseChoice::Candidate& candidate : choice->candidates) {
    EXPECT_LT(candidate.mean_distance, 4) << "all were brought together";
  }
}

TEST(LandmarkPose, GivesTheSameInAnyOrderOfTasks) {
  MemoryBlobStore store;
  const Scans scans = MakeScans(store, Axes::kAsTheyAre);
  const JobSpec spec = LandmarkSpec(store, scans.landmarks);
  const FinishedJob forward = RunJob(spec, scans.meshes, store);
  const FinishedJob backward = RunJob(spec, scans.meshes, store, Order::kBackward);
  EXPECT_EQ(forward.plan->Outputs().tiles, backward.plan->Outputs().tiles);
  EXPECT_EQ(forward.plan->Outputs().poses, backward.plan->Outputs().poses);
}

}  // namespace
}  // namespace cohort
