#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/base/error_reason.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "common/jobs/landmark_blob.h"
#include "common/store/directory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort::testing {

/// A task that a worker has done.
struct DoneTask {
  Task task;
  TaskResult result;
};

/// A coordinator with real files for catalog and store, and a worker that is a function call.
class StoreFixture : public ::testing::Test {
 protected:
  static constexpr int kPeople = 3;
  /// More than a signature has points, so that it is another blob than the correspondences.
  static constexpr int64_t kVertices = 600;

  StoreFixture() {
    folder_ = std::filesystem::temp_directory_path() /
              ("store_fixture-" + std::to_string(getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    store_ = DirectoryBlobStore::Create(folder_ / "blobs").value();
    options_.build = "1";
    options_.reserve = {.bytes = 0, .share = 0};
    Restart();
    for (const SetMesh& mesh : PutDemoScans(*store_, kPeople, 1, kVertices)) {
      EXPECT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
      meshes_.push_back(mesh);
    }
  }
  ~StoreFixture() override {
    coordinator_.reset();
    catalog_.reset();
    std::filesystem::remove_all(folder_);
  }

  void Restart() {
    coordinator_.reset();
    catalog_.reset();
    catalog_ = Catalog::Open(folder_ / "catalog.db").value();
    coordinator_ = Coordinator::Create(options_, *catalog_, *store_, clock_).value();
  }

  /// Landmarks of the scans: some of their vertices.
  Digest PutLandmarks() {
    DemoOptions options;
    options.people = kPeople;
    options.captures = 1;
    options.vertices = kVertices;
    LandmarkTable table;
    for (int person = 0; person < kPeople; ++person) {
      const DemoScan scan = MakeDemoScan(options, person, 0).value();
      table[scan.capture.file] = {
          {"a", "b", "c", "d"}, scan.mesh.vertices(Eigen::all, std::vector<int>{0, 70, 140, 210})};
    }
    return store_->Put(EncodeLandmarkBlob(table)).value();
  }

  /// A job that makes blobs of every kind.
  JobSpec EveryBlobSpec() {
    JobSpec spec;
    spec.rounds = 1;
    spec.icp.max_iterations = 3;
    spec.pose = PoseMode::kLandmarks;
    spec.landmarks = PutLandmarks();
    spec.compare.retention = Retention::kVectors;
    spec.preview = true;
    return spec;
  }

  Job Submit(JobSpec spec, bool fresh) {
    spec.fresh = fresh;
    clock_.Advance(1);
    Job job = coordinator_->CreateJob("set", spec, "").value();
    clock_.Advance(1);
    return job;
  }

  std::vector<GrantedTask> Take(int count) {
    WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = count};
    return coordinator_->Synchronize(report, [] { return false; })->grants;
  }

  /// Does one task as a worker would, failures included. @return what it did, if it went well.
  std::optional<DoneTask> DoOne(const std::function<void()>& before_report = [] {}) {
    const std::vector<GrantedTask> granted = Take(1);
    if (granted.empty()) {
      return std::nullopt;
    }
    clock_.Advance(0.01);
    const GrantedTask& grant = granted[0];
    MeshCache cache(*store_, 1 << 20);
    TaskRunner runner(*store_, cache);
    absl::StatusOr<TaskResult> result = runner.Run(grant.task, {});
    before_report();
    if (result.ok()) {
      const auto taken = coordinator_->CompleteTask(WorkerId{"w"}, grant.lease, *result);
      if (taken.ok()) {
        ++done_;
        return DoneTask{.task = grant.task, .result = *result};
      }
      EXPECT_EQ(ErrorReason(taken.status()), "BLOB_MISSING");
      result = absl::AbortedError(taken.status().message());
    }
    EXPECT_THAT(coordinator_->FailTask(WorkerId{"w"}, grant.lease, result.status()), IsOk());
    ++failed_;
    return std::nullopt;
  }

  /// Works until nothing is left or `stop` says so after a task.
  std::vector<DoneTask> Work(const std::function<bool(const DoneTask&)>& stop = {}) {
    std::vector<DoneTask> done;
    for (int idle = 0; idle < 3;) {
      const int before = failed_;
      std::optional<DoneTask> task = DoOne();
      if (!task) {
        idle += failed_ == before ? 1 : 0;
        clock_.Advance(5);  // Past any back-off.
        continue;
      }
      idle = 0;
      done.push_back(*std::move(task));
      if (stop && stop(done.back())) {
        break;
      }
    }
    return done;
  }

  [[nodiscard]] std::filesystem::path FileOf(const Digest& digest) const {
    return BlobPath(folder_ / "blobs", digest);
  }

  enum class Damage { kFlippedByte, kCutShort, kDeleted };
  static constexpr Damage kDamages[] = {Damage::kFlippedByte, Damage::kCutShort, Damage::kDeleted};
  void Spoil(const Digest& digest, Damage damage) const {
    const std::filesystem::path file = FileOf(digest);
    ASSERT_TRUE(std::filesystem::exists(file)) << file;
    const auto size = std::filesystem::file_size(file);
    std::filesystem::permissions(file, std::filesystem::perms(0644));
    if (damage == Damage::kDeleted) {
      std::filesystem::remove(file);
    } else if (damage == Damage::kCutShort) {
      std::filesystem::resize_file(file, size / 2);
    } else {
      std::fstream bytes(file, std::ios::binary | std::ios::in | std::ios::out);
      bytes.seekg(static_cast<std::streamoff>(size / 2));
      const char flipped = static_cast<char>(bytes.get() ^ 0x10);
      bytes.seekp(static_cast<std::streamoff>(size / 2));
      bytes.put(flipped);
    }
  }

  std::string OutputsOf(const Job& job) {
    const auto outputs = coordinator_->GetOutputs(job.id);
    return outputs.ok() ? ToJson(*outputs).dump() : std::string(outputs.status().message());
  }

  std::filesystem::path folder_;
  FakeClock clock_;
  CoordinatorOptions options_;
  std::unique_ptr<DirectoryBlobStore> store_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
  std::vector<SetMesh> meshes_;
  int done_ = 0;
  int failed_ = 0;
};

}  // namespace cohort::testing
