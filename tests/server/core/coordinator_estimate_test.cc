// What a job would take, told by a coordinator that has done some, and jobs that do not fit.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "common/base/error_reason.h"
#include "common/store/memory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort {
namespace {

using ::testing::Gt;
using ::testing::HasSubstr;
using testing::IsOk;
using ::testing::Lt;
using ::testing::Not;
using testing::StatusIs;

constexpr int kPeople = 6;
constexpr int kVertices = 1500;

class EstimateTest : public ::testing::Test {
 protected:
  EstimateTest() {
    std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(test.begin(), test.end(), '/', '-');  // Of a parameter.
    folder_ = std::filesystem::temp_directory_path() /
              ("estimate_test-" + std::to_string(getpid()) + "-" + test);
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    catalog_ = Catalog::Open(folder_ / "catalog.db").value();
    Restart();
    for (const SetMesh& mesh : testing::PutDemoScans(store_, kPeople, 1, kVertices)) {
      EXPECT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
    }
  }
  ~EstimateTest() override {
    coordinator_.reset();
    catalog_.reset();
    std::filesystem::remove_all(folder_);
  }

  void Restart() {
    CoordinatorOptions options;
    options.build = "1";
    options.reserve = {.bytes = 0, .share = 0};
    coordinator_ = Coordinator::Create(options, *catalog_, store_, clock_).value();
  }

  static JobSpec Spec(Retention retention = Retention::kSketch) {
    JobSpec spec;
    spec.rounds = 2;
    spec.icp.max_iterations = 5;
    spec.compare.retention = retention;
    return spec;
  }

  Estimate EstimateOf(const JobSpec& spec) {
    return coordinator_->EstimateJob("set", spec).value();
  }

  std::vector<GrantedTask> Take(int slots) {
    WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = slots};
    report.slots = slots;
    return coordinator_->Synchronize(report, [] { return false; })->grants;
  }

  /// Does all tasks, or so many. @param slowness  what each says it took, as a multiple of its
  /// cost.
  void Work(double slowness, int most = 1000) {
    MeshCache cache(store_, 1 << 24);
    TaskRunner runner(store_, cache);
    for (int done = 0; done < most; ++done) {
      const std::vector<GrantedTask> granted = Take(1);
      if (granted.empty()) {
        return;
      }
      TaskResult result = runner.Run(granted[0].task, {}).value();
      result.seconds = slowness * granted[0].task.cost;
      ASSERT_THAT(coordinator_->CompleteTask({"w"}, granted[0].lease, result), IsOk());
    }
  }

  int64_t StoredBytes() {
    int64_t bytes = 0;
    EXPECT_THAT(store_.Visit([&](const StoredBlob& blob) {
      bytes += blob.size_bytes;
      return absl::OkStatus();
    }),
                IsOk());
    return bytes;
  }

  static int64_t TasksOf(const Estimate& estimate) {
    return std::accumulate(estimate.stages.begin(), estimate.stages.end(), int64_t{0},
                           [](int64_t sum, const StageEstimate& s) { return sum + s.tasks; });
  }

  void LeaveFree(int64_t bytes) {
    store_.SetSpace({.free_bytes = bytes, .total_bytes = int64_t{1} << 50});
  }

  std::filesystem::path folder_;
  testing::FakeClock clock_;
  MemoryBlobStore store_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
};

TEST_F(EstimateTest, TellsTheTasksAndPairsThatTheJobThenHas) {
  const Estimate estimate = EstimateOf(Spec());
  EXPECT_EQ(estimate.meshes, kPeople);
  EXPECT_EQ(estimate.pairs, kPeople * (kPeople - 1));
  EXPECT_EQ(estimate.MeasuredShare(), 0);
  EXPECT_THAT(estimate.CoreSeconds(), Gt(0));
  EXPECT_EQ(estimate.slots, 0);
  EXPECT_EQ(estimate.wall_seconds, 0);
  std::vector<std::string> names;
  for (const StageEstimate& stage : estimate.stages) {
    names.push_back(stage.name);
  }
  EXPECT_THAT(names, ::testing::ElementsAre("ingest", "align 1", "average 1", "align 2",
                                            "average 2", "align 3", "summarize", "compare"));
  const Job job = coordinator_->CreateJob("set", Spec(), "").value();
  EXPECT_EQ(TasksOf(estimate), job.progress.tasks_total);
  EXPECT_DOUBLE_EQ(estimate.CoreSeconds(), job.progress.cost_total);
  EXPECT_EQ(coordinator_->ListJobs(0, "")->items.size(), 1U) << "an estimate is no job";
}

TEST_F(EstimateTest, GoesByWhatTasksHaveTakenHere) {
  ASSERT_THAT(coordinator_->CreateJob("set", Spec(), ""), IsOk());
  Work(3);
  const Estimate same = EstimateOf(Spec());
  EXPECT_DOUBLE_EQ(same.MeasuredShare(), 1);
  EXPECT_EQ(same.stages.front().name, "align 1") << "the meshes are known";
  // Tasks of another kind have not been seen; those of the same kind have.
  JobSpec surface = Spec();
  surface.compare.correspondence = Correspondence::kSurface;
  const Estimate mixed = EstimateOf(surface);
  EXPECT_THAT(mixed.MeasuredShare(), Gt(0));
  EXPECT_THAT(mixed.MeasuredShare(), Lt(1));
  for (const StageEstimate& stage : mixed.stages) {
    EXPECT_EQ(stage.is_measured, stage.name != "compare") << stage.name;
  }
  Restart();
  const Estimate assumed = EstimateOf(Spec());
  EXPECT_EQ(assumed.MeasuredShare(), 0) << "another start may be on another machine";
  EXPECT_NEAR(same.CoreSeconds(), 3 * assumed.CoreSeconds(), 1e-9);
}

TEST_F(EstimateTest, DividesTheWorkAmongTheSlotsThatThereAre) {
  Take(4);
  const Estimate estimate = EstimateOf(Spec());
  EXPECT_EQ(estimate.slots, 4);
  EXPECT_THAT(estimate.wall_seconds, Gt(estimate.CoreSeconds() / 4));
  EXPECT_THAT(estimate.wall_seconds, Lt(estimate.CoreSeconds()));
}

TEST_F(EstimateTest, OfMethodEachTellsWhatAverageWouldTake) {
  JobSpec spec = Spec();
  spec.method = Method::kEach;
  const Estimate each = EstimateOf(spec);
  EXPECT_DOUBLE_EQ(each.average_core_seconds, EstimateOf(Spec()).CoreSeconds());
  EXPECT_THAT(each.CoreSeconds(), Gt(each.average_core_seconds));
  EXPECT_EQ(EstimateOf(Spec()).average_core_seconds, 0);
}

TEST_F(EstimateTest, OfASetThatHasGrownCountsWhatTheReferenceJobLacks) {
  const Job first = coordinator_->CreateJob("set", Spec(), "").value();
  Work(1);
  for (const SetMesh& mesh : testing::PutDemoScans(store_, kPeople + 1, 1, kVertices)) {
    ASSERT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
  }
  JobSpec spec = Spec();
  spec.reference_job = first.id.value;
  const Estimate grown = EstimateOf(spec);
  EXPECT_EQ(grown.meshes, kPeople + 1);
  EXPECT_EQ(grown.pairs, 2 * kPeople);
  // Both read the new file; what follows is for it alone.
  const auto after_ingest = [](const Estimate& estimate) {
    return estimate.CoreSeconds() - estimate.stages.front().core_seconds;
  };
  EXPECT_EQ(grown.stages.front().name, "ingest");
  EXPECT_THAT(after_ingest(grown), Lt(0.5 * after_ingest(EstimateOf(Spec()))));
}

class BytesTest : public EstimateTest, public ::testing::WithParamInterface<Retention> {};

TEST_P(BytesTest, AreThoseThatTheJobWritesAndRatherMore) {
  const Estimate rough = EstimateOf(Spec(GetParam()));
  const int64_t at_first = StoredBytes();
  ASSERT_THAT(coordinator_->CreateJob("set", Spec(GetParam()), ""), IsOk());
  Work(1, kPeople);  // The ingest: from here on the meshes are known.
  const Estimate estimate = EstimateOf(Spec(GetParam()));
  EXPECT_EQ(estimate.retention, GetParam());
  const int64_t after_ingest = StoredBytes();
  Work(1);
  const auto written = static_cast<double>(StoredBytes() - after_ingest);
  const auto told = static_cast<double>(estimate.BytesWritten());
  RecordProperty("written", std::to_string(written));
  RecordProperty("told", std::to_string(told));
  EXPECT_GT(told, 0.97 * written);
  EXPECT_LT(told, 1.3 * written);
  const auto all = static_cast<double>(StoredBytes() - at_first);
  EXPECT_GT(static_cast<double>(rough.BytesWritten()), 0.4 * all) << "by the sizes of files";
  EXPECT_LT(static_cast<double>(rough.BytesWritten()), 2.5 * all);
}

INSTANTIATE_TEST_SUITE_P(OfAJob,
                         BytesTest,
                         ::testing::Values(Retention::kVectors,
                                           Retention::kCompact,
                                           Retention::kSketch,
                                           Retention::kMetrics),
                         [](const auto& kind) { return std::string(RetentionName(kind.param)); });

TEST_F(EstimateTest, AJobThatDoesNotFitIsRefusedWithTheNumbers) {
  const Estimate vectors = EstimateOf(Spec(Retention::kVectors));
  LeaveFree(vectors.BytesWritten() - 1);
  EXPECT_FALSE(EstimateOf(Spec(Retention::kVectors)).Fits());
  const absl::Status refused =
      coordinator_->CreateJob("set", Spec(Retention::kVectors), "").status();
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted, "30 pairs"));
  EXPECT_THAT(std::string(refused.message()), HasSubstr("--retention metrics would fit"));
  EXPECT_EQ(ErrorReason(refused), "STORE_TOO_SMALL");
  EXPECT_TRUE(coordinator_->ListJobs(0, "")->items.empty());
  EXPECT_THAT(coordinator_->CreateJob("set", Spec(Retention::kMetrics), ""), IsOk());
  LeaveFree(vectors.BytesWritten() + 2);  // Sums of rounded numbers.
  EXPECT_THAT(coordinator_->CreateJob("set", Spec(Retention::kVectors), ""), IsOk());
}

TEST_F(EstimateTest, AJobWhoseResultsAreThereNeedsNoRoom) {
  const JobSpec spec = Spec(Retention::kVectors);
  const Job first = coordinator_->CreateJob("set", spec, "request").value();
  LeaveFree(1);
  EXPECT_EQ(coordinator_->CreateJob("set", spec, "request")->id, first.id) << "asked again";
  EXPECT_THAT(coordinator_->CreateJob("set", spec, "other"),
              StatusIs(absl::StatusCode::kResourceExhausted, ""));
  Work(1);
  EXPECT_EQ(coordinator_->CreateJob("set", spec, "other")->state, JobState::kSucceeded);
  JobSpec fresh = spec;
  fresh.fresh = true;
  EXPECT_THAT(coordinator_->CreateJob("set", fresh, ""),
              StatusIs(absl::StatusCode::kResourceExhausted, ""));
}

TEST_F(EstimateTest, NamesWhatIsWrongAsTheJobWould) {
  EXPECT_THAT(coordinator_->EstimateJob("nothing", Spec()),
              StatusIs(absl::StatusCode::kNotFound, "nothing"));
  JobSpec spec = Spec();
  spec.base = "nobody.ply";
  EXPECT_THAT(coordinator_->EstimateJob("set", spec),
              StatusIs(absl::StatusCode::kInvalidArgument, "nobody.ply"));
  spec = Spec();
  spec.rounds = 0;
  EXPECT_THAT(coordinator_->EstimateJob("set", spec), Not(IsOk()));
}

}  // namespace
}  // namespace cohort
