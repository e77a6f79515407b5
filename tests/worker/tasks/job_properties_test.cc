// What must hold of the numbers of any job, whatever the meshes.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/geometry/io/write_mesh.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "common/store/memory_blob_store.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort {
namespace {

using testing::FinishedJob;
using testing::IsOk;
using testing::RmsOfPairs;
using testing::RunJob;

constexpr int kPeople = 4;
constexpr const char* kBase = "face1.ply";

std::vector<TriangleMesh> Faces() {
  DemoOptions options;
  options.people = kPeople;
  options.captures = 1;
  options.vertices = 800;
  std::vector<TriangleMesh> faces;
  faces.reserve(kPeople);
  for (int person = 0; person < kPeople; ++person) {
    faces.push_back(MakeDemoScan(options, person, 0)->mesh);
  }
  return faces;
}

SetMesh PutMesh(BlobStore& store, const std::string& name, const TriangleMesh& mesh) {
  const std::string bytes = WritePly(mesh);
  SetMesh put;
  put.name = name;
  put.raw = *store.Put(bytes);
  put.size_bytes = static_cast<int64_t>(bytes.size());
  return put;
}

std::vector<SetMesh> PutAll(BlobStore& store, const std::vector<TriangleMesh>& meshes) {
  std::vector<SetMesh> put;
  for (size_t i = 0; i < meshes.size(); ++i) {
    put.push_back(PutMesh(store, "face" + std::to_string(i) + ".ply", meshes[i]));
  }
  return put;
}

TriangleMesh Moved(TriangleMesh mesh, const Similarity& motion) {
  mesh.vertices = motion.Apply(mesh.vertices);
  return mesh;
}

Similarity SomeMotion(double scale) {
  Similarity motion;
  motion.scale = scale;
  motion.rotation =
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  motion.translation = Eigen::Vector3d(120, -40, 300);
  return motion;
}

JobSpec SpecFor(Method method) {
  JobSpec spec;
  spec.method = method;
  spec.base = kBase;
  spec.rounds = 2;
  return spec;
}

class JobProperties : public ::testing::TestWithParam<Method> {};

TEST_P(JobProperties, OrdersTheMetricsOfEveryPair) {
  MemoryBlobStore store;
  const FinishedJob job = RunJob(SpecFor(GetParam()), PutAll(store, Faces()), store);
  ASSERT_THAT(job.status, IsOk());
  for (const Digest& tile : job.plan->Outputs().tiles) {
    const std::vector<MetricBlock> blocks = *DecodeTileBlob(*store.Get(tile));
    for (const MetricBlock& block : blocks) {
      for (size_t place = 0; place < block.values.size(); ++place) {
        const MetricValues& v = block.values[place];
        const auto of = [&v](Metric metric) { return v[static_cast<size_t>(metric)]; };
        if (block.sources[place / block.targets.size()] ==
            block.targets[place % block.targets.size()]) {
          EXPECT_EQ(v, MetricValues{});
          continue;
        }
        EXPECT_GE(of(Metric::kMin), 0);
        EXPECT_LE(of(Metric::kMin), of(Metric::kGeometricMean));
        EXPECT_LE(of(Metric::kGeometricMean), of(Metric::kMean));
        EXPECT_LE(of(Metric::kMean), of(Metric::kRms));
        EXPECT_LE(of(Metric::kRms), of(Metric::kMax));
        EXPECT_LE(of(Metric::kPercentile75), of(Metric::kMax));
        EXPECT_NEAR(of(Metric::kVariance),
                    of(Metric::kRms) * of(Metric::kRms) - of(Metric::kMean) * of(Metric::kMean),
                    1e-9);
      }
    }
  }
}

TEST_P(JobProperties, DoNotDependOnTheOrderOfTheMeshes) {
  MemoryBlobStore store;
  const std::vector<TriangleMesh> faces = Faces();
  const FinishedJob job = RunJob(SpecFor(GetParam()), PutAll(store, faces), store);
  // The same meshes in reverse, with the same one as base.
  const std::vector<TriangleMesh> reversed(faces.rbegin(), faces.rend());
  JobSpec spec = SpecFor(GetParam());
  spec.base = "face2.ply";
  const FinishedJob backward = RunJob(spec, PutAll(store, reversed), store);
  ASSERT_THAT(backward.status, IsOk());
  auto expected = RmsOfPairs(job, store);
  for (const auto& [pair, rms] : RmsOfPairs(backward, store)) {
    const double forward = expected[{kPeople - 1 - pair.first, kPeople - 1 - pair.second}];
    if (GetParam() == Method::kAverage) {
      EXPECT_NEAR(rms, forward, 1e-3 * forward);  // sums in another order
    } else {
      EXPECT_EQ(rms, forward);
    }
  }
}

TEST_P(JobProperties, HardlyChangeUnderACommonRigidMotion) {
  MemoryBlobStore store;
  const std::vector<TriangleMesh> faces = Faces();
  std::vector<TriangleMesh> moved;
  moved.reserve(faces.size());
  for (const TriangleMesh& face : faces) {
    moved.push_back(Moved(face, SomeMotion(1)));
  }
  const FinishedJob still = RunJob(SpecFor(GetParam()), PutAll(store, faces), store);
  const FinishedJob turned = RunJob(SpecFor(GetParam()), PutAll(store, moved), store);
  ASSERT_THAT(turned.status, IsOk());
  auto expected = RmsOfPairs(still, store);
  for (const auto& [pair, rms] : RmsOfPairs(turned, store)) {
    // Draco rounds along other axes, and nearest neighbours flip: 800 vertices are 5 mm apart.
    EXPECT_NEAR(rms, expected[pair], 0.03 * expected[pair] + 1e-3) << pair.first << pair.second;
  }
}
INSTANTIATE_TEST_SUITE_P(Methods,
                         JobProperties,
                         ::testing::Values(Method::kAverage, Method::kOne, Method::kEach));

TEST(JobProperties, RecoverTheSimilarityOfACopiedMesh) {
  MemoryBlobStore store;
  const TriangleMesh face = Faces()[0];
  const Similarity motion = SomeMotion(1.07);
  const std::vector<SetMesh> meshes = {PutMesh(store, "face1.ply", face),
                                       PutMesh(store, "face2.ply", Moved(face, motion))};
  JobSpec spec = SpecFor(Method::kOne);
  spec.position_bits = 24;
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  for (const Digest& digest : job.plan->Outputs().alignments) {
    const std::vector<MeshAlignment> alignments = *DecodeAlignmentBlob(*store.Get(digest));
    for (const MeshAlignment& item : alignments) {
      const Similarity expected = item.mesh == 1 ? motion.Inverse() : Similarity{};
      const Similarity& found = item.alignment.T_target_source;
      const double degrees =
          Eigen::AngleAxisd(expected.rotation.transpose() * found.rotation).angle() * 180 / M_PI;
      EXPECT_LT(degrees, 0.01);
      EXPECT_NEAR(found.scale / expected.scale, 1, 1e-4);
      EXPECT_TRUE(item.alignment.converged);
    }
  }
}

}  // namespace
}  // namespace cohort
