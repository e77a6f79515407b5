// Whole jobs in one process: plan and task functions, no server, no network.
#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/geometry/comparison/distance_codec.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/comparison/sketch_measure.h"
#include "common/jobs/blobs.h"
#include "common/jobs/field_blob.h"
#include "common/store/memory_blob_store.h"
#include "common/store/mesh_blob.h"
#include "server/planning/job_plan.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/run_job.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort {
namespace {

using testing::FinishedJob;
using testing::IsOk;
using testing::Order;
using testing::QuickSpec;
using testing::RmsOfPairs;
using testing::RunJob;
using testing::StatusIs;

using ::testing::HasSubstr;

int64_t TotalVertices(const FinishedJob& job) {
  int64_t total = 0;
  for (const JobMesh& mesh : job.plan->Meshes()) {
    total += mesh.ingested->vertices;
  }
  return total;
}

TEST(Tasks, AverageCountsTheWorkOfTheThesis) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 5, 1);
  const JobSpec spec = QuickSpec(Method::kAverage);
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  ASSERT_TRUE(job.plan->Done());
  const int64_t N = 5;
  const int64_t M = spec.rounds;
  const int64_t base_vertices = job.plan->Meshes()[0].ingested->vertices;
  const Counters& counters = job.plan->TotalCounters();
  EXPECT_EQ(counters.align.index_builds + counters.average.index_builds, N * M + M + 1);
  EXPECT_EQ(counters.align.lookups + counters.average.lookups,
            TotalVertices(job) * spec.icp.max_iterations * (M + 1) + N * M * base_vertices);
  EXPECT_EQ(counters.pairs, N * N);
}

TEST(Tasks, OneCountsTheWorkOfTheThesis) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 5, 1);
  const JobSpec spec = QuickSpec(Method::kOne);
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_EQ(job.plan->TotalCounters().align.index_builds, 1);
  EXPECT_EQ(job.plan->TotalCounters().align.lookups, TotalVertices(job) * spec.icp.max_iterations);
}

TEST(Tasks, EachCountsTheWorkOfTheThesis) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 5, 1);
  const JobSpec spec = QuickSpec(Method::kEach);
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_EQ(job.plan->TotalCounters().align.index_builds, 5);
  EXPECT_EQ(job.plan->TotalCounters().align.lookups,
            5 * TotalVertices(job) * spec.icp.max_iterations);
}

TEST(Tasks, ResultsDoNotDependOnTheOrderOfTasks) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach, Method::kNone}) {
    MemoryBlobStore store;
    const auto meshes = testing::PutDemoScans(store, 3, 2);
    const FinishedJob forward = RunJob(QuickSpec(method), meshes, store);
    const FinishedJob backward = RunJob(QuickSpec(method), meshes, store, Order::kBackward);
    ASSERT_THAT(forward.status, IsOk());
    ASSERT_THAT(backward.status, IsOk());
    EXPECT_EQ(forward.plan->Outputs().tiles, backward.plan->Outputs().tiles);
    EXPECT_EQ(forward.plan->Outputs().mean_shape, backward.plan->Outputs().mean_shape);
    EXPECT_EQ(forward.plan->Outputs().summary, backward.plan->Outputs().summary);
    EXPECT_EQ(forward.plan->TotalCounters(), backward.plan->TotalCounters());
  }
}

TEST(Tasks, NoneMeasuresWhatBruteForceMeasures) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  const FinishedJob job = RunJob(QuickSpec(Method::kNone), meshes, store);
  ASSERT_THAT(job.status, IsOk());
  const auto pairs = RmsOfPairs(job, store);
  ASSERT_EQ(pairs.size(), 9U);
  std::vector<TriangleMesh> shapes;
  for (const JobMesh& mesh : job.plan->Meshes()) {
    shapes.push_back(*DecodeMeshBlob(*store.Get(mesh.ingested->blob)));
  }
  for (const auto& [pair, rms] : pairs) {
    const Eigen::Matrix3Xd& source = shapes[static_cast<size_t>(pair.first)].vertices;
    const Eigen::Matrix3Xd& target = shapes[static_cast<size_t>(pair.second)].vertices;
    double sum = 0;
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      sum += (target.colwise() - source.col(i)).colwise().squaredNorm().minCoeff();
    }
    // Distances are float32 on coordinates of about 100 mm.
    EXPECT_NEAR(rms, std::sqrt(sum / static_cast<double>(source.cols())), 2e-5);
  }
}

TEST(Tasks, EveryMethodFindsTheSamePersonNearest) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 2, 800);
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach}) {
    JobSpec spec;
    spec.method = method;
    const FinishedJob job = RunJob(spec, meshes, store);
    ASSERT_THAT(job.status, IsOk());
    auto pairs = RmsOfPairs(job, store);
    for (int i = 0; i < 6; ++i) {
      int nearest = -1;
      for (int j = 0; j < 6; ++j) {
        if (j != i && (nearest < 0 ||
                       pairs[{i, j}] + pairs[{j, i}] < pairs[{i, nearest}] + pairs[{nearest, i}])) {
          nearest = j;
        }
      }
      EXPECT_EQ(nearest / 2, i / 2) << MethodName(method) << ", mesh " << i;
    }
  }
}

TEST(Tasks, ABrokenFileIsRejectedAndTheOthersGoOn) {
  MemoryBlobStore store;
  auto meshes = testing::PutDemoScans(store, 3, 1);
  meshes.insert(meshes.begin(), testing::PutBrokenScan(store, "broken.ply"));
  const FinishedJob job = RunJob(QuickSpec(Method::kOne), meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_THAT(job.plan->Meshes()[0].rejection, HasSubstr("broken.ply"));
  EXPECT_EQ(RmsOfPairs(job, store).size(), 9U);
}

TEST(Tasks, AMissingBlobFailsTheTaskByName) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 2, 1);
  const std::unique_ptr<JobPlan> plan = *JobPlan::Create(QuickSpec(Method::kOne), meshes, {});
  MemoryBlobStore other;
  MeshCache cache(other, 1 << 20);
  TaskRunner runner(other, cache);
  const auto result = runner.Run(plan->TakeReadyTasks().at(0), {});
  EXPECT_THAT(result, StatusIs(absl::StatusCode::kNotFound, meshes[0].raw.Hex()));
}

TEST(Tasks, AStoppedTaskIsCancelled) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 2, 1);
  const std::unique_ptr<JobPlan> plan = *JobPlan::Create(QuickSpec(Method::kOne), meshes, {});
  MeshCache cache(store, 1 << 20);
  TaskRunner runner(store, cache);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THAT(runner.Run(plan->TakeReadyTasks().at(0), stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled, "stop"));
}

TEST(Tasks, AlignToAndMeasureSurfaces) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  const FinishedJob vertices = RunJob(QuickSpec(Method::kOne), meshes, store);
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach}) {
    JobSpec spec = QuickSpec(method);
    spec.icp.correspondence = Correspondence::kSurface;
    spec.compare.correspondence = Correspondence::kSurface;
    const FinishedJob surfaces = RunJob(spec, meshes, store);
    ASSERT_THAT(surfaces.status, IsOk());
    for (const auto& [pair, rms] : RmsOfPairs(surfaces, store)) {
      if (pair.first == pair.second) {
        EXPECT_EQ(rms, 0);
      } else {
        EXPECT_GT(rms, 0.1);
        EXPECT_LT(rms, RmsOfPairs(vertices, store)[pair]);  // 300 vertices: far apart
      }
    }
  }
}

/// From what was kept of the distances.
double RmsOf(const KeptField& field, Retention retention) {
  if (retention == Retention::kSketch) {
    return MeasureSketch(*DecodeSketch(field.bytes), {})->value.metrics[0];
  }
  const std::vector<float> distances = retention == Retention::kVectors
                                           ? *DecodeVectors(field.bytes, field.values)
                                           : DecodeCompact(field.bytes, field.values)->distances;
  DistanceScratch scratch;
  return MeasureDistances(distances, DistanceSign::kAbsolute, scratch).metrics[0];
}

TEST(Tasks, KeepTheDistancesThatTheMetricsComeFrom) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  for (const Retention retention : {Retention::kVectors, Retention::kCompact, Retention::kSketch}) {
    JobSpec spec = QuickSpec(Method::kOne);
    spec.compare.retention = retention;
    const FinishedJob job = RunJob(spec, meshes, store);
    ASSERT_THAT(job.status, IsOk());
    auto rms = RmsOfPairs(job, store);
    int pairs = 0;
    ASSERT_FALSE(job.plan->Outputs().fields.empty());
    for (const Digest& digest : job.plan->Outputs().fields) {
      const auto blob = DecodeFieldBlob(*store.Get(digest));
      ASSERT_THAT(blob, IsOk());
      EXPECT_EQ(blob->retention, retention);
      for (const FieldBlock& block : blob->blocks) {
        for (size_t place = 0; place < block.fields.size(); ++place) {
          const int source = block.sources[place / block.targets.size()];
          const int target = block.targets[place % block.targets.size()];
          EXPECT_EQ(RmsOf(block.fields[place], retention), (rms[{source, target}]));
          ++pairs;
        }
      }
    }
    EXPECT_EQ(pairs, 9);
  }
}

TEST(Tasks, KeepNothingIfOnlyMetricsAreWanted) {
  MemoryBlobStore store;
  JobSpec spec = QuickSpec(Method::kOne);
  spec.compare.retention = Retention::kAuto;
  spec.retention_budget = 0;
  const FinishedJob job = RunJob(spec, testing::PutDemoScans(store, 3, 1), store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_TRUE(job.plan->Outputs().fields.empty());
}

TEST(Tasks, ChooseTheMiddleMeshAsBase) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 5, 1, 600);
  JobSpec spec = QuickSpec(Method::kOne);
  spec.base_rule = BaseRule::kAuto;
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  const auto choice = DecodeBaseBlob(*store.Get(job.plan->Outputs().base_choice));
  ASSERT_THAT(choice, IsOk());
  ASSERT_EQ(choice->candidates.size(), 5U);
  // The exact medoid, from all pairs aligned to one another, is at most second to the chosen one.
  const FinishedJob each = RunJob(QuickSpec(Method::kEach), meshes, store);
  std::map<int, double> sums;
  for (const auto& [pair, rms] : RmsOfPairs(each, store)) {
    sums[pair.first] += rms;
    sums[pair.second] += rms;
  }
  int better = 0;
  for (const auto& [mesh, sum] : sums) {
    better += sum < sums[choice->base] ? 1 : 0;
  }
  EXPECT_LE(better, 1);
}

TEST(Tasks, StopRoundsOnceTheMeanShapeHasSettled) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  JobSpec spec = QuickSpec(Method::kAverage);
  spec.rounds = 6;
  spec.mean_tolerance = 1000;  // mm: the first round is enough
  const FinishedJob settled = RunJob(spec, meshes, store);
  ASSERT_THAT(settled.status, IsOk());
  spec.rounds = 1;
  spec.mean_tolerance = 0;
  const FinishedJob one_round = RunJob(spec, meshes, store);
  EXPECT_EQ(settled.plan->Outputs().mean_shape, one_round.plan->Outputs().mean_shape);
  EXPECT_EQ(settled.plan->TotalCounters(), one_round.plan->TotalCounters());
}

TEST(Tasks, UndersampleOnlyTheAlignment) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  JobSpec spec = QuickSpec(Method::kOne);
  spec.undersampling = {.method = UndersamplingMethod::kRandom, .count = 100};
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_EQ(job.plan->TotalCounters().align.lookups, 3 * 100 * spec.icp.max_iterations);
  EXPECT_EQ(job.plan->TotalCounters().compare.lookups, 3 * TotalVertices(job));
}

TEST(MeshCache, KeepsToItsLimitAndStillAnswers) {
  MemoryBlobStore store;
  TriangleMesh mesh;
  mesh.vertices = Eigen::Matrix3Xd::Random(3, 100);
  std::vector<Digest> blobs;
  for (int i = 0; i < 5; ++i) {
    mesh.vertices(0, 0) = i;
    blobs.push_back(*store.Put(EncodeRawMeshBlob(mesh)));
  }
  MeshCache cache(store, 5000);  // Two of them.
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 5; ++i) {
      const auto got = cache.Get(blobs[static_cast<size_t>(i)]);
      ASSERT_THAT(got, IsOk());
      EXPECT_EQ((*got)->vertices(0, 0), i);
    }
  }
  const auto first = cache.Get(blobs[4]);
  const auto second = cache.Get(blobs[4]);
  EXPECT_EQ(first->get(), second->get()) << "decoded twice although it fits";
}

}  // namespace
}  // namespace cohort
