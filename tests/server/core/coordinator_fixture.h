// The coordinator with a real catalog, a store in memory, a clock moved by hand, and workers that
// are plain function calls.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "common/store/memory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort {

inline constexpr double kLeaseSeconds = 10;

class CoordinatorTest : public ::testing::Test {
 protected:
  CoordinatorTest() {
    folder_ = std::filesystem::temp_directory_path() /
              ("coordinator_test-" + std::to_string(getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    Restart();
  }
  ~CoordinatorTest() override {
    coordinator_.reset();
    catalog_.reset();
    std::filesystem::remove_all(folder_);
  }

  /// As after a crash: only the catalog and the store remain.
  void Restart() {
    coordinator_.reset();
    catalog_.reset();
    catalog_ = *Catalog::Open(folder_ / "catalog.db");
    CoordinatorOptions options;
    options.scheduler.lease_seconds = kLeaseSeconds;
    options.build = "1";
    coordinator_ = *Coordinator::Create(options, *catalog_, store_, clock_);
  }

  void AddScans(int people, int captures) {
    for (const SetMesh& mesh : testing::PutDemoScans(store_, people, captures)) {
      ASSERT_THAT(coordinator_->AddMesh("set", mesh), testing::IsOk());
    }
  }

  Job Submit(const std::string& request_id = "", bool fresh = true) {
    JobSpec spec;
    spec.fresh = fresh;
    spec.rounds = 1;
    spec.icp.max_iterations = 3;
    return *coordinator_->CreateJob("set", spec, request_id);
  }

  std::vector<GrantedTask> Take(const std::string& worker, int count) {
    WorkerReport report{.worker = WorkerId{worker}, .build = "1", .held = {}, .free_slots = count};
    return coordinator_->Synchronize(report, [] { return false; })->grants;
  }

  absl::StatusOr<bool> Do(const std::string& worker, const GrantedTask& granted) {
    MeshCache cache(store_, 1 << 20);
    TaskRunner runner(store_, cache);
    return coordinator_->CompleteTask(WorkerId{worker}, granted.lease,
                                      *runner.Run(granted.task, {}));
  }

  /// Works until nothing is left, at most `limit` tasks.
  int Work(const std::string& worker, int limit = 1000) {
    int done = 0;
    while (done < limit) {
      const auto tasks = Take(worker, 1);
      if (tasks.empty()) {
        break;
      }
      EXPECT_THAT(Do(worker, tasks[0]), testing::IsOk());
      ++done;
    }
    return done;
  }

  std::filesystem::path folder_;
  testing::FakeClock clock_;
  MemoryBlobStore store_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
};

}  // namespace cohort
