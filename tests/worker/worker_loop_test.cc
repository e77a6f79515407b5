#include "worker/worker_loop.h"

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "common/base/error_reason.h"
#include "common/base/mutex.h"
#include "common/store/memory_blob_store.h"
#include "server/planning/job_plan.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

/// A server that hands out prepared tasks and remembers what it was told.
class FakeLink final : public CoordinatorLink {
 public:
  absl::StatusOr<WorkerOrders> Synchronize(const WorkerReport& report) override {
    MutexLock lock(mutex_);
    ++synchronizes_;
    if (cancelled_) {
      return absl::CancelledError("stopping");
    }
    if (!refusal_.ok()) {
      return refusal_;
    }
    return Answer(report);
  }
  absl::StatusOr<std::optional<WorkerOrders>> CompleteTask(
      const WorkerId&,
      const Lease& lease,
      const TaskResult&,
      const std::optional<WorkerReport>& report) override {
    MutexLock lock(mutex_);
    ++sending_;
    changed_.NotifyAll();
    while (is_slow_) {
      changed_.Wait(mutex_);
    }
    if (failures_to_make_ > 0) {
      --failures_to_make_;
      return absl::UnavailableError("the network is down");
    }
    completed_.push_back(lease.task.number);
    carried_ += report ? 1 : 0;
    changed_.NotifyAll();
    return report ? std::optional(Answer(*report)) : std::nullopt;
  }
  absl::Status ReleaseTask(const WorkerId&, const Lease& lease) override {
    MutexLock lock(mutex_);
    released_.push_back(lease.task.number);
    return absl::OkStatus();
  }
  absl::Status FailTask(const WorkerId&, const Lease& lease, const absl::Status& why) override {
    MutexLock lock(mutex_);
    failed_[lease.task.number] = why;
    changed_.NotifyAll();
    return absl::OkStatus();
  }
  void CancelSynchronize() override {
    MutexLock lock(mutex_);
    cancelled_ = true;
  }

  void WaitForReports(size_t count) {
    MutexLock lock(mutex_);
    while (completed_.size() + failed_.size() < count) {
      changed_.Wait(mutex_);
    }
  }

  /// Gives as many tasks as it asks for, each once, as the server does.
  WorkerOrders Answer(const WorkerReport& report) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    WorkerOrders orders;
    orders.next_sync_seconds = next_sync_seconds_;
    orders.lease_seconds = 60;
    const int wanted = report.free_slots + report.spare_slots;
    for (int i = 0; i < wanted && !tasks_.empty(); ++i) {
      GrantedTask granted;
      granted.task = tasks_.front();
      tasks_.pop_front();
      granted.lease.task = {.job = JobId{"j"}, .number = granted.task.number};
      granted.lease.epoch = 1;
      orders.grants.push_back(granted);
    }
    max_held_ = std::max(max_held_, report.held.size() + orders.grants.size());
    granted_ += orders.grants.size();
    changed_.NotifyAll();
    return orders;
  }

  Mutex mutex_;
  CondVar changed_;
  std::deque<Task> tasks_ ABSL_GUARDED_BY(mutex_);
  std::vector<int64_t> completed_ ABSL_GUARDED_BY(mutex_);
  std::vector<int64_t> released_ ABSL_GUARDED_BY(mutex_);
  std::map<int64_t, absl::Status> failed_ ABSL_GUARDED_BY(mutex_);
  absl::Status refusal_ ABSL_GUARDED_BY(mutex_);
  size_t max_held_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t granted_ ABSL_GUARDED_BY(mutex_) = 0;
  int synchronizes_ ABSL_GUARDED_BY(mutex_) = 0;
  int sending_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Calls that brought a result.
  int carried_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Those that brought a report too.
  double next_sync_seconds_ ABSL_GUARDED_BY(mutex_) = 0.01;
  bool is_slow_ ABSL_GUARDED_BY(mutex_) = false;  ///< Results are not taken for now.
  int failures_to_make_ ABSL_GUARDED_BY(mutex_) = 0;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
};

/// Can be closed: then some more blobs can be read, and none be written, until it is let go.
class GatedStore final : public BlobStore {
 public:
  explicit GatedStore(BlobStore& store) : store_(store) {}

  absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override {
    Pass(false);
    return store_.StartPut();
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override {
    Pass(true);
    return store_.Open(digest);
  }
  absl::StatusOr<bool> Contains(const Digest& digest) override { return store_.Contains(digest); }

  void CloseAfterReads(int count) {
    const MutexLock lock(mutex_);
    is_open_ = false;
    reads_left_ = count;
  }
  void LetGo() {
    const MutexLock lock(mutex_);
    is_open_ = true;
    changed_.NotifyAll();
  }

 private:
  void Pass(bool is_read) {
    MutexLock lock(mutex_);
    while (!is_open_ && !(is_read && reads_left_ > 0)) {
      changed_.Wait(mutex_);
    }
    reads_left_ -= is_read ? 1 : 0;
  }

  BlobStore& store_;
  Mutex mutex_;
  CondVar changed_;
  bool is_open_ ABSL_GUARDED_BY(mutex_) = true;
  int reads_left_ ABSL_GUARDED_BY(mutex_) = 0;
};

/// Ingest tasks of small scans, numbered from 0.
std::deque<Task> IngestTasks(BlobStore& store, int count) {
  JobSpec spec;
  const auto plan = JobPlan::Create(spec, testing::PutDemoScans(store, count, 1), {});
  std::deque<Task> tasks;
  for (Task& task : (*plan)->TakeReadyTasks()) {
    tasks.push_back(std::move(task));
  }
  return tasks;
}

class WorkerLoopTest : public ::testing::Test {
 protected:
  /// Starts a loop with `slots` slots on a thread of its own.
  void Start(int slots) {
    options_.worker = WorkerId{"w"};
    options_.slots = slots;
    thread_ = std::thread([this] {
      WorkerLoop loop(options_, link_, runner_);
      status_ = loop.Run(stop_.get_token());
    });
  }
  void Stop() {
    stop_.request_stop();
    thread_.join();
  }

  MemoryBlobStore store_;
  GatedStore gate_{store_};
  MeshCache cache_{gate_, 1 << 20};
  TaskRunner runner_{gate_, cache_};
  FakeLink link_;
  WorkerLoopOptions options_;
  std::stop_source stop_;
  absl::Status status_;
  std::thread thread_;
};

TEST_F(WorkerLoopTest, RunsEveryTaskOnceInItsSlots) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 6);
  }
  Start(2);
  link_.WaitForReports(6);
  Stop();
  EXPECT_THAT(status_, IsOk());
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.completed_, ::testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_LE(link_.max_held_, 5U);  // One is held ready besides, two may be on their way back.
  EXPECT_TRUE(link_.failed_.empty());
}

TEST_F(WorkerLoopTest, AsksForTheNextTaskWhileAResultIsOnItsWayButNotForever) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 4);
    link_.is_slow_ = true;
  }
  options_.spare_slots = 0;
  Start(1);
  {
    MutexLock lock(link_.mutex_);
    while (link_.granted_ < 2) {
      link_.changed_.Wait(link_.mutex_);
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  {
    MutexLock lock(link_.mutex_);
    EXPECT_EQ(link_.granted_, 2U) << "results heap up before a slow server";
    link_.is_slow_ = false;
    link_.changed_.NotifyAll();
  }
  link_.WaitForReports(4);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.completed_, ::testing::UnorderedElementsAre(0, 1, 2, 3));
}

TEST_F(WorkerLoopTest, GetsTheNextTaskWithTheAnswerToAResult) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 16);
    link_.next_sync_seconds_ = 60;
    ASSERT_EQ(link_.tasks_.size(), 16U);
  }
  Start(1);
  link_.WaitForReports(16);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_GE(link_.carried_, 4) << "a call of its own for nearly every task";
}

TEST_F(WorkerLoopTest, AsksForTheNextTaskIfWritingTakesLong) {
  gate_.CloseAfterReads(1);
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 6);
    link_.next_sync_seconds_ = 60;
  }
  Start(1);
  {
    // The first is being written, the second computes: it has no third to wait for its slot.
    MutexLock lock(link_.mutex_);
    while (link_.granted_ < 3) {
      link_.changed_.Wait(link_.mutex_);
    }
    EXPECT_EQ(link_.sending_, 0);
  }
  gate_.LetGo();
  link_.WaitForReports(6);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.completed_, ::testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5));
}

TEST_F(WorkerLoopTest, FollowsOrdersThatALaterReportHasOvertaken) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 6);
    link_.is_slow_ = true;
  }
  Start(1);
  {
    MutexLock lock(link_.mutex_);
    while (link_.sending_ == 0) {
      link_.changed_.Wait(link_.mutex_);
    }
    const int before = link_.synchronizes_;
    while (link_.synchronizes_ < before + 3) {  // Its time comes while the result is on its way.
      link_.changed_.Wait(link_.mutex_);
    }
    link_.is_slow_ = false;
    link_.changed_.NotifyAll();
  }
  link_.WaitForReports(6);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.completed_, ::testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5));
}

TEST_F(WorkerLoopTest, GivesBackWhatItIsGivenAfterItsStop) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 6);
    link_.is_slow_ = true;
    link_.next_sync_seconds_ = 60;
  }
  Start(1);
  {
    MutexLock lock(link_.mutex_);
    while (link_.sending_ < 1) {
      link_.changed_.Wait(link_.mutex_);
    }
  }
  stop_.request_stop();
  {
    MutexLock lock(link_.mutex_);
    link_.is_slow_ = false;
    link_.changed_.NotifyAll();
  }
  thread_.join();
  MutexLock lock(link_.mutex_);
  EXPECT_EQ(link_.completed_.size() + link_.released_.size(), link_.granted_)
      << "a task that nobody knows of waits for the end of its lease";
}

TEST_F(WorkerLoopTest, SaysAResultAgainUntilTheServerHasIt) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 2);
    link_.failures_to_make_ = 2;
  }
  Start(1);
  link_.WaitForReports(2);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.completed_, ::testing::UnorderedElementsAre(0, 1));
}

TEST_F(WorkerLoopTest, ReportsAFailureAndGoesOn) {
  {
    MutexLock lock(link_.mutex_);
    link_.tasks_ = IngestTasks(store_, 2);
    link_.tasks_[0].meshes[0].blob = Sha256::Of("not there");
  }
  Start(1);
  link_.WaitForReports(2);
  Stop();
  MutexLock lock(link_.mutex_);
  EXPECT_THAT(link_.failed_[0], StatusIs(absl::StatusCode::kNotFound, ""));
  EXPECT_THAT(link_.completed_, ::testing::ElementsAre(1));
}

TEST_F(WorkerLoopTest, EndsWhenTheServerRefusesItsBuild) {
  {
    MutexLock lock(link_.mutex_);
    link_.refusal_ = WithReason(absl::FailedPreconditionError("other build"), "BUILD_MISMATCH");
  }
  Start(1);
  thread_.join();
  EXPECT_THAT(status_, StatusIs(absl::StatusCode::kFailedPrecondition, "other build"));
}

}  // namespace
}  // namespace cohort
