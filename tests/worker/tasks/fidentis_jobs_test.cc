// Jobs with the predecessor's arithmetic, through plan, tasks and blobs.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/geometry/comparison/distance_codec.h"
#include "common/geometry/io/write_mesh.h"
#include "common/jobs/field_blob.h"
#include "common/jobs/placed_blob.h"
#include "common/store/memory_blob_store.h"
#include "tests/testing/demo_scans.h"
#include "tests/worker/tasks/fidentis_jobs.h"

namespace cohort {
namespace {

using testing::DirectFidentis;
using testing::ExpectSame;
using testing::FinishedJob;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::MetricsOfPairs;
using testing::Order;
using testing::PutDemoScans;
using testing::RunJob;
using testing::RunJobWithWorkers;
using testing::StatusIs;

JobSpec QuickFidentis(Method method) {
  JobSpec spec = FidentisSpec(method);
  spec.rounds = 2;
  spec.icp.max_iterations = 4;
  return spec;
}

class FidentisJobs : public ::testing::TestWithParam<Method> {};

TEST_P(FidentisJobs, GiveWhatTheLibraryGivesHoweverManyWorkers) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 3, 2);
  const JobSpec spec = QuickFidentis(GetParam());
  const DirectFidentis direct(spec, meshes, store);
  ASSERT_NO_FATAL_FAILURE(ExpectSame(RunJob(spec, meshes, store), store, direct));
  ASSERT_NO_FATAL_FAILURE(ExpectSame(RunJob(spec, meshes, store, Order::kBackward), store, direct));
  for (const uint64_t seed : {1, 2, 3}) {
    ASSERT_NO_FATAL_FAILURE(
        ExpectSame(RunJobWithWorkers(spec, meshes, store, 3, seed), store, direct));
  }
}

TEST_P(FidentisJobs, GiveWhatTheLibraryGivesWithAnotherBaseWithSignsAndWithoutScale) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 3, 1);
  JobSpec spec = QuickFidentis(GetParam());
  spec.compare.sign = DistanceSign::kSigned;
  spec.icp.scale_mode = ScaleMode::kOff;
  spec.base = meshes[2].name;
  const FinishedJob job = RunJob(spec, meshes, store);
  ExpectSame(job, store, DirectFidentis(spec, meshes, store));
  // Otherwise the signs were not looked at.
  const MetricValues pair = MetricsOfPairs(job, store)[{0, 1}];
  EXPECT_LT(pair[static_cast<size_t>(Metric::kMin)], 0);
  EXPECT_GT(pair[static_cast<size_t>(Metric::kMax)], 0);
  EXPECT_TRUE(std::isnan(pair[static_cast<size_t>(Metric::kGeometricMean)]));
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         FidentisJobs,
                         ::testing::Values(Method::kAverage, Method::kOne, Method::kEach),
                         [](const auto& method) { return std::string(MethodName(method.param)); });

TEST(FidentisJob, GivesWhatTheLibraryGivesInSeveralTiles) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 9, 2, 600);
  const JobSpec spec = QuickFidentis(Method::kAverage);
  const FinishedJob job = RunJobWithWorkers(spec, meshes, store, 3, 7);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_GE(job.plan->Outputs().tiles.size(), 3U);
  ExpectSame(job, store, DirectFidentis(spec, meshes, store));
}

TEST(FidentisJob, HasOtherNumbersThanOurs) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 3, 1);
  const FinishedJob theirs = RunJob(QuickFidentis(Method::kOne), meshes, store);
  const FinishedJob ours = RunJob(testing::QuickSpec(Method::kOne), meshes, store);
  EXPECT_NE(theirs.plan->Outputs().tiles, ours.plan->Outputs().tiles);
}

TEST(FidentisJob, ReportsTransformationsFromTheFile) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 3, 1);
  const JobSpec spec = QuickFidentis(Method::kAverage);
  const FinishedJob job = RunJob(spec, meshes, store);
  const DirectFidentis direct(spec, meshes, store);
  size_t seen = 0;
  for (const Digest& blob : job.plan->Outputs().alignments) {
    const auto alignments = *DecodeAlignmentBlob(*store.Get(blob));
    for (const MeshAlignment& item : alignments) {
      const auto index = static_cast<size_t>(item.mesh);
      const FileMesh file = *ReadFileMesh(*store.Get(meshes[index].raw), meshes[index].name);
      const Eigen::Matrix3Xd applied =
          item.alignment.T_target_source.Apply(file.vertices.cast<double>());
      // The moved floats differ by what up to 3 x 5 steps rounded, some 1e-5 mm each.
      EXPECT_LE((applied - direct.Placed()[index].cast<double>()).cwiseAbs().maxCoeff(), 2e-4);
      EXPECT_GE(item.alignment.iterations, 2);
      EXPECT_LE(item.alignment.iterations, 5);
      EXPECT_TRUE(std::isnan(item.alignment.overlap)) << "nobody measured it";
      EXPECT_GE(item.alignment.rms_residual, item.alignment.mean_residual);
      EXPECT_GT(item.alignment.mean_residual, 0);
      ++seen;
    }
  }
  EXPECT_EQ(seen, 3U);
}

TEST(FidentisJob, KeepsTheSignedDistancesThatTheMetricsComeFrom) {
  MemoryBlobStore store;
  const auto meshes = PutDemoScans(store, 3, 1);
  JobSpec spec = QuickFidentis(Method::kOne);
  spec.compare.retention = Retention::kVectors;
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  auto metrics = MetricsOfPairs(job, store);
  int fields = 0;
  bool has_negative = false;
  for (const Digest& digest : job.plan->Outputs().fields) {
    const auto blob = *DecodeFieldBlob(*store.Get(digest));
    for (const FieldBlock& block : blob.blocks) {
      for (size_t place = 0; place < block.fields.size(); ++place, ++fields) {
        const auto distances =
            *DecodeVectors(block.fields[place].bytes, block.fields[place].values);
        has_negative = has_negative || *std::min_element(distances.begin(), distances.end()) < 0;
        EXPECT_TRUE(testing::SameValues(metrics[{block.sources[place / block.targets.size()],
                                                 block.targets[place % block.targets.size()]}],
                                        ComputeFidentisMetrics(FidentisAbsolute(distances))));
      }
    }
  }
  EXPECT_EQ(fields, 9);
  EXPECT_TRUE(has_negative);
}

// ---- Odd meshes, as the predecessor takes them ----

SetMesh PutFile(BlobStore& store, const std::string& name, const std::string& bytes) {
  SetMesh mesh;
  mesh.name = name;
  mesh.raw = *store.Put(bytes);
  mesh.size_bytes = static_cast<int64_t>(bytes.size());
  return mesh;
}

/// Three demo scans as OBJ, with more lines at the end of the second.
std::vector<SetMesh> PutObjScans(BlobStore& store, const std::string& more) {
  std::vector<SetMesh> meshes;
  for (int person = 0; person < 3; ++person) {
    DemoOptions options;
    options.people = 3;
    options.captures = 1;
    options.vertices = 300;
    const std::string bytes = WriteObj(MakeDemoScan(options, person, 0)->mesh);
    meshes.push_back(
        PutFile(store, std::to_string(person) + ".obj", person == 1 ? bytes + more : bytes));
  }
  return meshes;
}

/// So small that all of it is nearest to one vertex of a face: its scale comes out as 0.
SetMesh PutSpeck(BlobStore& store) {
  return PutFile(store, "speck.obj", "v 5 0 0\nv 5.001 0 0\nv 5 0.001 0\nf 1 2 3\n");
}

TEST(FidentisJob, AVertexInNoFaceMakesTheWholeRowNaN) {
  MemoryBlobStore store;
  const auto meshes = PutObjScans(store, "v 1 2 3\n");
  const JobSpec spec = QuickFidentis(Method::kOne);
  const FinishedJob job = RunJob(spec, meshes, store);
  ExpectSame(job, store, DirectFidentis(spec, meshes, store));
  for (const auto& [pair, metrics] : MetricsOfPairs(job, store)) {
    EXPECT_EQ(std::isnan(metrics[0]), pair.first == 1) << pair.first << " " << pair.second;
  }
  const MeshHealth& health = job.plan->Meshes()[1].ingested->health;
  EXPECT_THAT(health.warnings.back(), HasSubstr("1 vertices without a normal"));
  EXPECT_THAT(health.warnings.back(), HasSubstr("NaN"));
  for (const std::string& warning : health.warnings) {
    EXPECT_THAT(warning, ::testing::Not(HasSubstr("removed"))) << "nothing is";
  }
}

TEST(FidentisJob, NormalsOfTheFileGiveTheSignsAndAreNotTurned) {
  MemoryBlobStore store;
  std::string normals;
  for (int i = 0; i < 400; ++i) {  // more than there are vertices
    normals += "vn 0 0 1\n";
  }
  const auto meshes = PutObjScans(store, normals);
  JobSpec spec = QuickFidentis(Method::kAverage);
  spec.compare.sign = DistanceSign::kSigned;
  const FinishedJob with = RunJob(spec, meshes, store);
  ExpectSame(with, store, DirectFidentis(spec, meshes, store));
  const FinishedJob without = RunJob(spec, PutObjScans(store, ""), store);
  auto with_normals = MetricsOfPairs(with, store);
  auto without_normals = MetricsOfPairs(without, store);
  const auto mean = static_cast<size_t>(Metric::kMean);
  EXPECT_NE((with_normals[{1, 0}][mean]), (without_normals[{1, 0}][mean]));
  EXPECT_EQ((with_normals[{0, 1}][mean]), (without_normals[{0, 1}][mean]));
  EXPECT_EQ((with_normals[{1, 0}][0]), (without_normals[{1, 0}][0])) << "RMS has no sign";
}

TEST(FidentisJob, RefusesACloudWithoutNormalsAndMeshesThatCannotBeAligned) {
  MemoryBlobStore store;
  auto meshes = PutObjScans(store, "");
  meshes.push_back(PutFile(store, "cloud.obj", "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\n"));
  meshes.push_back(PutSpeck(store));
  JobSpec spec = QuickFidentis(Method::kOne);
  spec.size_ratio_limit = 0;
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  EXPECT_THAT(job.plan->Meshes()[3].rejection,
              HasSubstr("cloud.obj: a point cloud without normals"));
  EXPECT_THAT(job.plan->Meshes()[4].rejection, HasSubstr("speck.obj: not aligned: fidentis ICP"));
  EXPECT_EQ(MetricsOfPairs(job, store).size(), 9U);
}

TEST(FidentisJob, EachHasNaNForAPairThatCannotBeAligned) {
  MemoryBlobStore store;
  auto meshes = PutObjScans(store, "");
  meshes.push_back(PutSpeck(store));
  JobSpec spec = QuickFidentis(Method::kEach);
  spec.size_ratio_limit = 0;
  const FinishedJob job = RunJob(spec, meshes, store);
  ASSERT_THAT(job.status, IsOk());
  for (const auto& [pair, metrics] : MetricsOfPairs(job, store)) {
    if (pair.first == 3 && pair.second != 3) {
      EXPECT_TRUE(std::isnan(metrics[0])) << pair.second;
    }
  }
  const auto summary = *DecodeSummaryBlob(*store.Get(job.plan->Outputs().summary));
  EXPECT_EQ(summary.mesh_count, 3);
}

// ---- Damaged inputs ----

/// The first task of `stage`, with the job run up to it.
Task FirstTaskOf(const std::string& stage, JobPlan& plan, BlobStore& store) {
  MeshCache cache(store, 1 << 20);
  TaskRunner runner(store, cache);
  while (true) {
    const std::vector<Task> ready = plan.TakeReadyTasks();
    if (ready.empty() || ready.front().stage == stage) {
      return ready.at(0);
    }
    for (const Task& task : ready) {
      EXPECT_THAT(plan.TaskFinished(task.number, *runner.Run(task, {})), IsOk());
    }
  }
}

class DamagedFidentisInput : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const auto meshes = PutDemoScans(store_, 2, 1);
    plan_ = *JobPlan::Create(QuickFidentis(Method::kAverage), meshes, {});
    task_ = FirstTaskOf(GetParam(), *plan_, store_);
  }
  [[nodiscard]] absl::StatusOr<TaskResult> Run(const Task& task) {
    MeshCache cache(store_, 1 << 20);
    return TaskRunner(store_, cache).Run(task, {});
  }
  MemoryBlobStore store_;
  std::unique_ptr<JobPlan> plan_;
  Task task_;
};

TEST_P(DamagedFidentisInput, FailsTheTaskForGood) {
  ASSERT_THAT(Run(task_), IsOk());
  Task task = task_;
  task.partials = {*store_.Put("COHPLCD1 and no more")};
  EXPECT_THAT(Run(task), StatusIs(absl::StatusCode::kDataLoss, "placed blob"));
  task = task_;
  std::vector<PlacedMesh> others = *DecodePlacedBlob(*store_.Get(task.partials.at(0)));
  others[0].vertices = others[0].vertices.leftCols(others[0].vertices.cols() - 1).eval();
  if (!task.meshes.empty() || !task.targets.empty()) {
    task.partials[0] = *store_.Put(EncodePlacedBlob(others));
    EXPECT_FALSE(Run(task).ok()) << "a vertex is missing";
  }
  task = task_;
  for (std::vector<TaskMesh>* meshes : {&task.meshes, &task.targets}) {
    for (TaskMesh& mesh : *meshes) {
      mesh.blob = *store_.Put(EncodeRawMeshBlob(TriangleMesh()));
    }
  }
  if (task.meshes != task_.meshes || task.targets != task_.targets) {
    EXPECT_THAT(Run(task), StatusIs(absl::StatusCode::kDataLoss, "mesh blob: has encoding 0"));
  }
}

INSTANTIATE_TEST_SUITE_P(Stages,
                         DamagedFidentisInput,
                         ::testing::Values("average 1", "align 2", "compare"),
                         [](const auto& stage) { return stage.param.substr(0, 5); });

TEST(FidentisTask, OfAKindThatThePredecessorLacksIsRefused) {
  MemoryBlobStore store;
  MeshCache cache(store, 1 << 20);
  Task task;
  task.kind = TaskKind::kPose;
  task.arithmetic = Arithmetic::kFidentis;
  EXPECT_THAT(TaskRunner(store, cache).Run(task, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "\"pose\""));
}

}  // namespace
}  // namespace cohort
