// Sets that grow and shrink: jobs that keep the frame of an earlier one.
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include <gmock/gmock.h>

#include "common/base/error_reason.h"
#include "common/store/memory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/task_runner.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

/// Directed values by the names of source and target.
using NamedMatrix = std::map<std::pair<std::string, std::string>, double>;

class ReferenceJobTest : public ::testing::Test {
 protected:
  ReferenceJobTest() : folder_(::testing::TempDir() + "/" + UniqueFolder()) {
    std::filesystem::create_directories(folder_);
    scans_ = testing::PutDemoScans(store_, 4, 2);
    Restart();
  }
  ~ReferenceJobTest() override {
    coordinator_.reset();
    catalog_.reset();
    std::filesystem::remove_all(folder_);
  }

  static std::string UniqueFolder() {
    return std::string("reference-") +
           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  void Restart() {
    coordinator_.reset();
    catalog_.reset();
    catalog_ = *Catalog::Open(folder_ / "catalog.db");
    coordinator_ = *Coordinator::Create({.scheduler = {}, .build = "1"}, *catalog_, store_, clock_);
  }
  void Add(std::initializer_list<size_t> scans) {
    for (const size_t scan : scans) {
      ASSERT_THAT(coordinator_->AddMesh("set", scans_[scan]), IsOk());
    }
  }
  /// Works until nothing is left; the tasks by stage.
  std::map<std::string, int> Work(int limit = 1000) {
    std::map<std::string, int> done;
    WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {}, .free_slots = 1};
    for (int i = 0; i < limit; ++i) {
      const auto grants = coordinator_->Synchronize(report, [] { return false; })->grants;
      if (grants.empty()) {
        break;
      }
      MeshCache cache(store_, 1 << 24);
      TaskRunner runner(store_, cache);
      const auto result = runner.Run(grants[0].task, {});
      EXPECT_THAT(result, IsOk());
      EXPECT_THAT(coordinator_->CompleteTask({"w"}, grants[0].lease, *result), IsOk());
      ++done[grants[0].task.stage];
    }
    return done;
  }
  Job Submit(const JobSpec& spec) {
    absl::StatusOr<Job> job = coordinator_->CreateJob("set", spec, "");
    EXPECT_THAT(job, IsOk());
    return job.ok() ? *job : Job();
  }
  Job Finish(const JobSpec& spec) {
    const Job job = Submit(spec);
    Work();
    Job done = *coordinator_->GetJob(job.id);
    EXPECT_EQ(done.state, JobState::kSucceeded) << done.error;
    return done;
  }
  static JobSpec Spec(Method method) {
    JobSpec spec;
    spec.method = method;
    spec.rounds = 1;
    spec.icp.max_iterations = 3;
    return spec;
  }
  static JobSpec AddingTo(const Job& job) {
    JobSpec spec;
    spec.reference_job = job.id.value;
    return spec;
  }
  NamedMatrix MatrixOf(const Job& job) {
    const auto meshes = *coordinator_->GetJobMeshes(job.id);
    NamedMatrix matrix;
    EXPECT_THAT(coordinator_->GetMatrix(
                    job.id, Metric::kRms,
                    [&](const MatrixBlock& block) {
                      size_t place = 0;
                      for (const int32_t source : block.sources) {
                        for (const int32_t target : block.targets) {
                          const std::pair pair(meshes.at(static_cast<size_t>(source)).mesh.name,
                                               meshes.at(static_cast<size_t>(target)).mesh.name);
                          EXPECT_TRUE(matrix.emplace(pair, block.values[place++]).second)
                              << pair.first << " to " << pair.second << " twice";
                        }
                      }
                      return true;
                    }),
                IsOk());
    return matrix;
  }

  std::filesystem::path folder_;
  testing::FakeClock clock_;
  MemoryBlobStore store_;
  std::vector<SetMesh> scans_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
};

class GrowingSetTest : public ReferenceJobTest, public ::testing::WithParamInterface<Method> {};

INSTANTIATE_TEST_SUITE_P(Methods,
                         GrowingSetTest,
                         ::testing::Values(Method::kAverage, Method::kOne, Method::kNone),
                         [](const auto& method) { return std::string(MethodName(method.param)); });

TEST_P(GrowingSetTest, AlignsAndComparesOnlyWhatIsNew) {
  Add({1, 2, 4, 5, 7});
  const Job first = Finish(Spec(GetParam()));
  const NamedMatrix before = MatrixOf(first);
  Add({0, 3});  // Between and before the others: every index changes.
  const Job grown = Submit(AddingTo(first));
  std::map<std::string, int> done = Work();
  EXPECT_EQ(done["ingest"], 2);
  EXPECT_EQ(done.contains("align"), GetParam() != Method::kNone);
  const Job ended = *coordinator_->GetJob(grown.id);
  ASSERT_EQ(ended.state, JobState::kSucceeded) << ended.error;
  EXPECT_EQ(ended.counters.pairs, 2 * 5 * 2 + 2 * 2) << "k (2 N + k)";
  const NamedMatrix after = MatrixOf(grown);
  EXPECT_EQ(after.size(), 49U);
  for (const auto& [pair, value] : before) {
    EXPECT_EQ(after.at(pair), value) << "what was measured stays to the bit";
  }
  for (const auto& [pair, value] : after) {
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_EQ(value == 0, pair.first == pair.second);
  }
  EXPECT_FALSE(coordinator_->GetOutputs(grown.id)->mean_shape.empty());
}

// With a fixed base the frame does not depend on the set: then a set that grew is the same as one
// that was there from the beginning.
TEST_F(ReferenceJobTest, GrowingGivesTheSameBytesAsAllAtOnce) {
  JobSpec spec = Spec(Method::kOne);
  spec.base = scans_[1].name;
  Add({1, 2, 5});
  const Job first = Finish(spec);
  Add({0, 4});
  const Job second = Finish(AddingTo(first));
  Add({3});
  const Job third = Finish(AddingTo(second));  // A chain.
  spec.fresh = true;
  const Job at_once = Finish(spec);
  EXPECT_EQ(MatrixOf(third), MatrixOf(at_once));
  EXPECT_EQ(coordinator_->GetOutputs(third.id)->mean_shape,
            coordinator_->GetOutputs(at_once.id)->mean_shape);
  EXPECT_EQ(coordinator_->GetOutputs(third.id)->summary,
            coordinator_->GetOutputs(at_once.id)->summary);
}

TEST_F(ReferenceJobTest, WhatIsDeletedCostsNothingButItsRows) {
  Add({0, 1, 2, 3, 4});
  const Job first = Finish(Spec(Method::kAverage));
  const NamedMatrix before = MatrixOf(first);
  ASSERT_THAT(coordinator_->RemoveMesh("set", scans_[0].name), IsOk());
  ASSERT_THAT(coordinator_->RemoveMesh("set", scans_[3].name), IsOk());
  const Job job = Submit(AddingTo(first));
  const auto done = Work();
  EXPECT_FALSE(done.contains("compare"));
  EXPECT_FALSE(done.contains("align"));
  ASSERT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  const NamedMatrix after = MatrixOf(job);
  EXPECT_EQ(after.size(), 9U);
  for (const auto& [pair, value] : after) {
    EXPECT_EQ(before.at(pair), value);
  }
  EXPECT_EQ(coordinator_->GetOutputs(job.id)->alignments.size(), 1U);
}

TEST_F(ReferenceJobTest, AMeshWithOtherBytesUnderItsNameIsNew) {
  Add({0, 1, 2});
  const Job first = Finish(Spec(Method::kAverage));
  ASSERT_THAT(coordinator_->RemoveMesh("set", scans_[1].name), IsOk());
  SetMesh other = scans_[6];
  other.name = scans_[1].name;
  ASSERT_THAT(coordinator_->AddMesh("set", other), IsOk());
  const Job job = Finish(AddingTo(first));
  EXPECT_EQ(job.counters.pairs, 2 * 2 + 1);
}

TEST_F(ReferenceJobTest, GoesOnAfterARestartAndAfterARetry) {
  Add({0, 1, 2, 3});
  const Job first = Finish(Spec(Method::kAverage));
  Add({4, 5});
  JobSpec spec = AddingTo(first);
  spec.fresh = true;
  const NamedMatrix calm = MatrixOf(Finish(spec));
  for (int stop_after = 0; stop_after < 8; ++stop_after) {
    const Job job = Submit(spec);
    Work(stop_after);
    Restart();
    ASSERT_THAT(coordinator_->CancelJob(job.id), IsOk());
    ASSERT_THAT(coordinator_->RetryJob(job.id), IsOk());
    Work();
    ASSERT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded) << stop_after;
    EXPECT_EQ(MatrixOf(job), calm) << stop_after;
  }
}

TEST_F(ReferenceJobTest, RefusesAReferenceThatCannotBeAddedTo) {
  Add({0, 1, 2});
  const Job each = Finish(Spec(Method::kEach));
  const Job queued = Submit(Spec(Method::kOne));
  for (const Job& job : {each, queued}) {
    const auto refused = coordinator_->CreateJob("set", AddingTo(job), "");
    EXPECT_EQ(ErrorReason(refused.status()), "REFERENCE_UNUSABLE");
    EXPECT_THAT(refused, StatusIs(absl::StatusCode::kFailedPrecondition, job.id.value));
  }
  JobSpec unknown;
  unknown.reference_job = "j-000099";
  EXPECT_THAT(coordinator_->CreateJob("set", unknown, ""),
              StatusIs(absl::StatusCode::kNotFound, "j-000099"));
  Work();
  for (const SetMesh& mesh : {scans_[5], scans_[6]}) {
    ASSERT_THAT(coordinator_->AddMesh("others", mesh), IsOk());
  }
  EXPECT_THAT(coordinator_->CreateJob("others", AddingTo(queued), ""),
              StatusIs(absl::StatusCode::kInvalidArgument, "has no mesh"));
}

}  // namespace
}  // namespace cohort
