// A store with little space: nothing new is begun, nothing that runs is lost, and all goes on by
// itself.
#include <string>

#include "common/store/memory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/server/core/store_fixture.h"

namespace cohort {
namespace {

using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

constexpr int64_t kGigabyte = 1'000'000'000;

class CoordinatorSpaceTest : public ::testing::Test {
 protected:
  CoordinatorSpaceTest() {
    CoordinatorOptions options;
    options.build = "1";
    catalog_ = Catalog::Open(folder_.Path() / "catalog.db").value();
    coordinator_ = Coordinator::Create(options, *catalog_, store_, clock_).value();
    for (const SetMesh& mesh : testing::PutDemoScans(store_, 3, 1)) {
      EXPECT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
    }
    spec_.rounds = 1;
    spec_.icp.max_iterations = 3;
  }

  std::vector<GrantedTask> Take() {
    WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = 1};
    return coordinator_->Synchronize(report, [] { return false; })->grants;
  }
  absl::Status Do(const GrantedTask& granted) {
    MeshCache cache(store_, 1 << 20);
    TaskRunner runner(store_, cache);
    return coordinator_
        ->CompleteTask(WorkerId{"w"}, granted.lease, runner.Run(granted.task, {}).value())
        .status();
  }
  void SetFree(double gigabytes) {
    store_.SetSpace({.free_bytes = static_cast<int64_t>(gigabytes * kGigabyte),
                     .total_bytes = 100 * kGigabyte});
    EXPECT_THAT(coordinator_->Tick(), IsOk());
  }

  testing::ScratchFolder folder_;
  testing::FakeClock clock_;
  MemoryBlobStore store_;
  JobSpec spec_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
};

TEST_F(CoordinatorSpaceTest, WaitsWithoutSpaceAndGoesOnByItself) {
  const Job job = *coordinator_->CreateJob("set", spec_, "");
  const auto running = Take();
  ASSERT_EQ(running.size(), 1U);

  SetFree(4.9);  // Of 100: less than a twentieth.

  EXPECT_TRUE(Take().empty());
  const Job waiting = *coordinator_->GetJob(job.id);
  EXPECT_THAT(waiting.progress.waiting_for, HasSubstr("4.90 GB free of 100.00 GB"));
  EXPECT_GT(waiting.version, job.version) << "watchers hear of it";
  EXPECT_THAT(Do(running[0]), IsOk()) << "what runs may end";
  EXPECT_THAT(coordinator_->GetJob(job.id)->progress.waiting_for, HasSubstr("4.90 GB"));
  const auto refused = coordinator_->CreateJob("set", spec_, "");
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted, "keeps 5.00 GB in reserve"));
  EXPECT_EQ(ErrorReason(refused.status()), "STORE_FULL");

  SetFree(5.1);

  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.waiting_for, "");
  EXPECT_EQ(Take().size(), 1U);
  EXPECT_THAT(coordinator_->CreateJob("set", spec_, ""), IsOk());
}

TEST_F(CoordinatorSpaceTest, AWriteThatFailedForWantOfSpaceIsNotTheTasksFault) {
  const Job job = *coordinator_->CreateJob("set", spec_, "");
  for (int i = 0; i < 10; ++i) {
    const auto granted = Take();
    ASSERT_EQ(granted.size(), 1U) << i;
    SetFree(0);
    EXPECT_THAT(coordinator_->FailTask(WorkerId{"w"}, granted[0].lease,
                                       absl::ResourceExhaustedError("No space left on device")),
                IsOk());
    EXPECT_TRUE(Take().empty());
    SetFree(50);
  }
  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_given_up, 0);
}

TEST_F(CoordinatorSpaceTest, AWorkerOutOfMemoryIsAnotherMatter) {
  const Job job = *coordinator_->CreateJob("set", spec_, "");
  for (int i = 0; i < 12 && !IsFinal(coordinator_->GetJob(job.id)->state); ++i) {
    for (const GrantedTask& granted : Take()) {
      EXPECT_THAT(coordinator_->FailTask(WorkerId{"w"}, granted.lease,
                                         absl::ResourceExhaustedError("out of memory")),
                  IsOk());
    }
    clock_.Advance(60);
  }
  EXPECT_THAT(coordinator_->GetJob(job.id)->error, HasSubstr("out of memory"));
}

TEST_F(CoordinatorSpaceTest, SmallDisksHaveAReserveInBytes) {
  store_.SetSpace({.free_bytes = kGigabyte, .total_bytes = 2 * kGigabyte});
  EXPECT_THAT(coordinator_->CheckSpace(),
              StatusIs(absl::StatusCode::kResourceExhausted, "keeps 1.07 GB in reserve"));
}

/// The same on a disk that is really full.
class FullDiskTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!disk_.Mounted()) {
      GTEST_SKIP() << "cannot mount a small disk: not root";
    }
    store_ = DirectoryBlobStore::Create(disk_.Path()).value();
    catalog_ = Catalog::Open(folder_.Path() / "catalog.db").value();
    CoordinatorOptions options;
    options.build = "1";
    options.reserve = {.bytes = 500'000, .share = 0};
    coordinator_ = Coordinator::Create(options, *catalog_, *store_, clock_).value();
    for (const SetMesh& mesh : testing::PutDemoScans(*store_, 3, 1)) {
      ASSERT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
    }
  }

  void DoOne() {
    WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = 1};
    const WorkerOrders orders = coordinator_->Synchronize(report, [] { return false; }).value();
    waits_ += orders.grants.empty() ? 1 : 0;
    for (const GrantedTask& granted : orders.grants) {
      MeshCache cache(*store_, 1 << 20);
      TaskRunner runner(*store_, cache);
      if (want_full_) {
        Fill();
      }
      const auto result = runner.Run(granted.task, {});
      if (result.ok()) {
        EXPECT_THAT(coordinator_->CompleteTask(WorkerId{"w"}, granted.lease, *result), IsOk());
        continue;
      }
      ++failures_;
      EXPECT_THAT(result, StatusIs(absl::StatusCode::kResourceExhausted, "No space left"));
      EXPECT_THAT(coordinator_->FailTask(WorkerId{"w"}, granted.lease, result.status()), IsOk());
    }
  }

  /// Of every ten steps the disk is full in four.
  enum class DiskIs { kRoomy, kFullAtTimes };
  std::string RunJob(DiskIs disk) {
    JobSpec spec;
    spec.rounds = 3;
    spec.icp.max_iterations = 3;
    const Job job = coordinator_->CreateJob("set", spec, "").value();
    for (int i = 0; i < 400 && !IsFinal(coordinator_->GetJob(job.id)->state); ++i) {
      want_full_ = disk == DiskIs::kFullAtTimes && i % 10 >= 3 && i % 10 < 7;
      if (!want_full_ && !filler_.empty()) {
        EXPECT_THAT(store_->Remove(filler_), IsOk());
      }
      EXPECT_THAT(coordinator_->Tick(), IsOk());
      DoOne();
      clock_.Advance(1);
    }
    const auto outputs = coordinator_->GetOutputs(job.id);
    EXPECT_THAT(outputs, IsOk());
    return outputs.ok() ? ToJson(*outputs).dump() : "";
  }

  /// Leaves less than a page.
  void Fill() {
    std::string bytes(static_cast<size_t>(store_->Space()->free_bytes), 'x');
    absl::StatusOr<Digest> put = store_->Put(bytes);
    while (!put.ok()) {
      bytes.resize(bytes.size() - 4096);
      put = store_->Put(bytes);
    }
    filler_ = *put;
  }

  const testing::SmallDisk disk_{"6m"};
  const testing::ScratchFolder folder_;  // The catalog has its own disk here.
  testing::FakeClock clock_;
  std::unique_ptr<DirectoryBlobStore> store_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
  bool want_full_ = false;
  Digest filler_;
  int waits_ = 0;
  int failures_ = 0;
};

TEST_F(FullDiskTest, AJobOnItWaitsAndEndsInTheSameResultsOnceThereIsSpace) {
  const std::string expected = RunJob(DiskIs::kRoomy);
  ASSERT_EQ(failures_, 0);
  waits_ = 0;
  const Page<Job> jobs = coordinator_->ListJobs(10, "").value();
  ASSERT_THAT(coordinator_->DeleteJob(jobs.items.at(0).id), IsOk());
  // All blobs but the files go, so that the job must write them again.
  ASSERT_THAT(coordinator_->CollectGarbage({.age_seconds = 0, .remember_seconds = 0}), IsOk());

  EXPECT_EQ(RunJob(DiskIs::kFullAtTimes), expected);

  EXPECT_GE(failures_, 2);
  EXPECT_GT(waits_, 3);
}

}  // namespace
}  // namespace cohort
