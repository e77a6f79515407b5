#include "server/core/coordinator.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/base/error_reason.h"
#include "tests/server/core/coordinator_fixture.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort {
namespace {

using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

TEST_F(CoordinatorTest, AJobSubmittedAgainEndsAtOnceWithoutAnyTask) {
  AddScans(4, 1);
  const Job first = Submit("", false);
  const int tasks = Work("w");
  EXPECT_GT(tasks, 4);
  const Job again = Submit("", false);
  EXPECT_EQ(again.state, JobState::kSucceeded);
  EXPECT_EQ(again.progress.tasks_reused, tasks);
  EXPECT_EQ(again.progress.tasks_done, again.progress.tasks_total);
  EXPECT_EQ(again.counters, coordinator_->GetJob(first.id)->counters);
  EXPECT_EQ(coordinator_->GetOutputs(again.id)->tiles, coordinator_->GetOutputs(first.id)->tiles);
  EXPECT_EQ(coordinator_->GetOutputs(again.id)->mean_shape,
            coordinator_->GetOutputs(first.id)->mean_shape);
  // Asked to, it computes everything.
  EXPECT_EQ(Submit("", true).state, JobState::kQueued);
  EXPECT_EQ(Work("w"), tasks);
}

TEST_F(CoordinatorTest, WhatIsKnownButGoneFromTheStoreIsComputedAgain) {
  AddScans(3, 1);
  const Job first = Submit("", false);
  const int tasks = Work("w");
  const Digest lost = coordinator_->GetOutputs(first.id)->tiles.at(0);
  ASSERT_THAT(store_.Remove(lost), IsOk());
  const Job again = Submit("", false);
  EXPECT_FALSE(IsFinal(again.state));
  EXPECT_EQ(Work("w"), 1);
  EXPECT_EQ(coordinator_->GetJob(again.id)->progress.tasks_reused, tasks - 1);
  EXPECT_EQ(coordinator_->GetOutputs(again.id)->tiles.at(0), lost);
}

TEST_F(CoordinatorTest, APausedJobHandsOutNothingAlsoAfterARestart) {
  AddScans(3, 1);
  const Job job = Submit();
  const auto held = Take("w", 1);
  ASSERT_EQ(held.size(), 1U);
  EXPECT_EQ(coordinator_->PauseJob(job.id)->state, JobState::kPaused);
  EXPECT_TRUE(Take("other", 9).empty());
  EXPECT_EQ(*Do("w", held[0]), true) << "what is out may end";
  Restart();
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kPaused);
  EXPECT_TRUE(Take("other", 9).empty());
  EXPECT_EQ(coordinator_->ResumeJob(job.id)->state, JobState::kRunning);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  EXPECT_EQ(ErrorReason(coordinator_->PauseJob(job.id).status()), "JOB_FINISHED");
}

TEST_F(CoordinatorTest, AFailedJobGoesOnWhenItIsTriedAgain) {
  AddScans(3, 1);
  const Job calm = Submit();
  Work("w");
  const Job job = Submit();
  // One ingest is refused for good; the others are done all the same before the job fails.
  const auto first = Take("w", 1);
  ASSERT_THAT(coordinator_->FailTask({"w"}, first[0].lease, absl::DataLossError("the disk rots")),
              IsOk());
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kRunning);
  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_given_up, 1);
  Restart();
  EXPECT_EQ(Work("w"), 2);
  const Job failed = *coordinator_->GetJob(job.id);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_EQ(failed.error, "task 0 (ingest): the disk rots");
  EXPECT_EQ(ErrorReason(coordinator_->RetryJob(calm.id).status()), "JOB_NOT_FAILED");
  EXPECT_EQ(coordinator_->RetryJob(job.id)->state, JobState::kRunning);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  EXPECT_EQ(coordinator_->GetOutputs(job.id)->tiles, coordinator_->GetOutputs(calm.id)->tiles);
}

TEST_F(CoordinatorTest, ACancelledJobGoesOnWhereItWas) {
  AddScans(3, 1);
  const Job job = Submit();
  ASSERT_EQ(Work("w", 4), 4);
  EXPECT_EQ(coordinator_->CancelJob(job.id)->state, JobState::kCancelled);
  EXPECT_TRUE(Take("w", 1).empty());
  const Job again = *coordinator_->RetryJob(job.id);
  EXPECT_EQ(again.progress.tasks_done, 4);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
}

TEST_F(CoordinatorTest, AResultThatDoesNotFitItsTaskIsRefusedAndTheTaskGoesOn) {
  AddScans(2, 1);
  Submit();
  const auto held = Take("w", 1);
  TaskResult nonsense;
  nonsense.rejections = {{77, "no such mesh"}};
  EXPECT_THAT(coordinator_->CompleteTask({"w"}, held[0].lease, nonsense),
              StatusIs(absl::StatusCode::kInvalidArgument, ""));
  EXPECT_EQ(*Do("w", held[0]), true);
}

TEST_F(CoordinatorTest, ListsItsWorkersWithWhatTheyDo) {
  AddScans(2, 1);
  Submit();
  const auto held = Take("anna", 1);
  EXPECT_EQ(*Do("anna", held[0]), true);
  clock_.Advance(5);
  Take("bert", 1);
  const std::vector<WorkerStatus> workers = coordinator_->ListWorkers();
  ASSERT_EQ(workers.size(), 2U);
  EXPECT_EQ(workers[0].worker.value, "anna");
  EXPECT_EQ(workers[0].tasks_done, 1);
  EXPECT_EQ(workers[0].silent_seconds, 5);
  EXPECT_EQ(workers[1].silent_seconds, 0);
}

TEST_F(CoordinatorTest, TakesBackWhatSilentWorkersHadWithoutAnyCall) {
  AddScans(2, 1);
  Submit();
  ASSERT_EQ(Take("silent", 1).size(), 1U);
  clock_.Advance(kLeaseSeconds + 1);
  EXPECT_THAT(coordinator_->Tick(), IsOk());
  EXPECT_EQ(Take("w", 9).size(), 2U);
  clock_.Advance(100 * kLeaseSeconds);
  EXPECT_THAT(coordinator_->Tick(), IsOk());
  EXPECT_TRUE(coordinator_->ListWorkers().empty()) << "forgotten in the end";
}

TEST_F(CoordinatorTest, FillsSpareSlotsOnlyWhileOthersHaveEnough) {
  AddScans(5, 1);
  Submit();
  WorkerReport report{
      .worker = WorkerId{"greedy"}, .build = "1", .held = {}, .free_slots = 1, .spare_slots = 1};
  const auto first = coordinator_->Synchronize(report, [] { return false; });
  ASSERT_EQ(first->grants.size(), 2U);  // Five were ready.
  report.worker = WorkerId{"late"};
  const auto second = coordinator_->Synchronize(report, [] { return false; });
  EXPECT_EQ(second->grants.size(), 1U);  // Of the three left others may need the rest.
  report.worker = WorkerId{"leaving"};
  report.draining = true;
  EXPECT_TRUE(coordinator_->Synchronize(report, [] { return false; })->grants.empty());
}

TEST_F(CoordinatorTest, RefusesLandmarksThatAreNotInTheStore) {
  AddScans(2, 1);
  JobSpec spec;
  spec.pose = PoseMode::kLandmarks;
  spec.landmarks = Sha256::Of("never written");
  const auto refused = coordinator_->CreateJob("set", spec, "");
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kFailedPrecondition, spec.landmarks.Hex()));
  EXPECT_EQ(ErrorReason(refused.status()), "BLOB_MISSING");
}

TEST_F(CoordinatorTest, GoesOnWithSymmetricCopiesAfterARestartAndKeepsTheOriginals) {
  AddScans(3, 1);
  JobSpec spec;
  spec.method = Method::kOne;
  spec.icp.max_iterations = 3;
  const Job plain = *coordinator_->CreateJob("set", spec, "");
  Work("w");
  spec.symmetric_copies = true;
  const Job calm = *coordinator_->CreateJob("set", spec, "");
  Work("w");
  spec.fresh = true;
  const Job broken_off = *coordinator_->CreateJob("set", spec, "");
  ASSERT_EQ(Work("w", 7), 7);  // The copies are made, and one pose.
  Restart();
  Work("w");
  EXPECT_EQ(coordinator_->GetOutputs(broken_off.id)->tiles,
            coordinator_->GetOutputs(calm.id)->tiles);
  EXPECT_NE(coordinator_->GetOutputs(plain.id)->tiles, coordinator_->GetOutputs(calm.id)->tiles);
  EXPECT_TRUE(coordinator_->GetJobMeshes(broken_off.id)->at(2).copy.has_value());
  spec.symmetric_copies = false;
  const Job again = *coordinator_->CreateJob("set", spec, "");
  Work("w");
  EXPECT_EQ(coordinator_->GetOutputs(again.id)->tiles, coordinator_->GetOutputs(plain.id)->tiles);
}

TEST_F(CoordinatorTest, RunsAJobToItsEnd) {
  AddScans(3, 1);
  const Job job = Submit();
  EXPECT_EQ(job.state, JobState::kQueued);
  Work("w");
  const Job done = *coordinator_->GetJob(job.id);
  EXPECT_EQ(done.state, JobState::kSucceeded);
  EXPECT_EQ(done.progress.tasks_done, done.progress.tasks_total);
  EXPECT_EQ(done.counters.pairs, 9);
  EXPECT_THAT(coordinator_->GetOutputs(job.id), IsOk());
}

TEST_F(CoordinatorTest, AKilledWorkersTaskIsDoneByAnother) {
  AddScans(3, 1);
  const Job job = Submit();
  const auto lost = Take("killed", 2);
  ASSERT_EQ(lost.size(), 2U);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kRunning);
  clock_.Advance(kLeaseSeconds + 1);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
}

TEST_F(CoordinatorTest, ATaskWhoseGrantWasLostOnTheWayIsGivenOutAgainSoon) {
  AddScans(2, 1);
  const Job job = Submit();
  const auto lost = Take("w", 1);
  ASSERT_EQ(lost.size(), 1U);
  clock_.Advance(kLeaseSeconds / 2 + 1);  // Long before its lease ends.
  bool came_again = false;
  for (const GrantedTask& granted : Take("w", 9)) {
    came_again |= granted.lease.task == lost[0].lease.task;
    EXPECT_NE(granted.lease, lost[0].lease);
    EXPECT_EQ(*Do("w", granted), true);
  }
  EXPECT_TRUE(came_again);
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
}

TEST_F(CoordinatorTest, ALateResultIsTakenOnceAndThenSuperseded) {
  AddScans(3, 1);
  Submit();
  const auto slow = Take("slow", 1);
  clock_.Advance(kLeaseSeconds + 1);
  const auto again = Take("quick", 1);
  ASSERT_EQ(again[0].lease.task, slow[0].lease.task);
  EXPECT_GT(again[0].lease.epoch, slow[0].lease.epoch);
  EXPECT_EQ(*Do("slow", slow[0]), true);
  EXPECT_EQ(*Do("quick", again[0]), false);
}

TEST_F(CoordinatorTest, ARestartAtAnyPointEndsInTheSameOutputs) {
  AddScans(3, 1);
  const Job calm = Submit();
  const int tasks = Work("w");
  const JobOutputs expected = *coordinator_->GetOutputs(calm.id);
  for (int stop_after = 0; stop_after < tasks; stop_after += 3) {
    const Job job = Submit();
    Work("w", stop_after);
    const auto held = Take("w", 1);
    Restart();
    // The worker reports in with what it runs; nobody else gets that.
    clock_.Advance(kLeaseSeconds / 2);
    for (const GrantedTask& granted : held) {
      EXPECT_EQ(*Do("w", granted), true) << "after " << stop_after;
    }
    Work("other");
    ASSERT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded) << stop_after;
    const JobOutputs outputs = *coordinator_->GetOutputs(job.id);
    EXPECT_EQ(outputs.tiles, expected.tiles);
    EXPECT_EQ(outputs.mean_shape, expected.mean_shape);
    EXPECT_EQ(coordinator_->GetJob(job.id)->counters, coordinator_->GetJob(calm.id)->counters);
  }
}

TEST_F(CoordinatorTest, TheSameRequestIdGivesTheSameJobAlsoAfterARestart) {
  AddScans(2, 1);
  const Job first = Submit("request");
  EXPECT_EQ(Submit("request").id, first.id);
  Restart();
  EXPECT_EQ(Submit("request").id, first.id);
  EXPECT_NE(Submit("another").id, first.id);
}

TEST_F(CoordinatorTest, FilesIngestedBeforeAreNotIngestedAgain) {
  AddScans(3, 1);
  Submit();
  Work("w");
  JobSpec other;
  other.icp.max_iterations = 4;
  ASSERT_THAT(coordinator_->CreateJob("set", other, ""), IsOk());
  const auto tasks = Take("w", 1);
  ASSERT_EQ(tasks.size(), 1U);
  EXPECT_NE(tasks[0].task.kind, TaskKind::kIngest);
}

TEST_F(CoordinatorTest, ATaskThatAlwaysFailsFailsItsJobWithTheReason) {
  AddScans(2, 1);
  const Job job = Submit();
  for (int i = 0; i < 10 && !IsFinal(coordinator_->GetJob(job.id)->state); ++i) {
    for (const GrantedTask& granted : Take("w", 1)) {
      EXPECT_THAT(coordinator_->FailTask(WorkerId{"w"}, granted.lease,
                                         absl::UnavailableError("disk on fire")),
                  IsOk());
    }
    clock_.Advance(60);
  }
  const Job failed = *coordinator_->GetJob(job.id);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_THAT(failed.error, HasSubstr("disk on fire"));
  EXPECT_EQ(ErrorReason(coordinator_->GetOutputs(job.id).status()), "JOB_NOT_FINISHED");
}

TEST_F(CoordinatorTest, AReleasedTaskIsGrantedAgainAtOnce) {
  AddScans(2, 1);
  Submit();
  const auto first = Take("w", 1);
  EXPECT_THAT(coordinator_->ReleaseTask(WorkerId{"w"}, first[0].lease), IsOk());
  const auto second = Take("w2", 1);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].lease.task, first[0].lease.task);
}

TEST_F(CoordinatorTest, ACancelledJobGrantsNothingAndTellsItsWorkers) {
  AddScans(2, 1);
  const Job job = Submit();
  const auto held = Take("w", 1);
  EXPECT_EQ(coordinator_->CancelJob(job.id)->state, JobState::kCancelled);
  WorkerReport report{.worker = WorkerId{"w"}, .build = "1", .held = {{held[0].lease, 1}}};
  report.free_slots = 1;
  const WorkerOrders orders = *coordinator_->Synchronize(report, [] { return false; });
  EXPECT_TRUE(orders.grants.empty());
  EXPECT_THAT(orders.lost, ::testing::ElementsAre(held[0].lease));
  EXPECT_EQ(*Do("w", held[0]), false);
}

TEST_F(CoordinatorTest, AWorkerOfAnotherBuildIsRefused) {
  WorkerReport report{.worker = WorkerId{"w"}, .build = "2", .held = {}, .free_slots = 1};
  const auto refused = coordinator_->Synchronize(report, [] { return false; });
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kFailedPrecondition, "same version"));
  EXPECT_EQ(ErrorReason(refused.status()), "BUILD_MISMATCH");
}

TEST_F(CoordinatorTest, AResultWhoseBlobIsNotInTheStoreIsRefused) {
  AddScans(2, 1);
  Submit();
  const auto granted = Take("w", 1);
  TaskResult result;
  result.output = Sha256::Of("never written");
  const auto answer = coordinator_->CompleteTask(WorkerId{"w"}, granted[0].lease, result);
  EXPECT_EQ(ErrorReason(answer.status()), "BLOB_MISSING");
}

TEST_F(CoordinatorTest, AMeshWithoutItsBytesIsRefused) {
  SetMesh mesh;
  mesh.name = "a.ply";
  mesh.raw = Sha256::Of("never sent");
  EXPECT_EQ(ErrorReason(coordinator_->AddMesh("set", mesh).status()), "BLOB_MISSING");
  mesh.name = "../a.ply";
  EXPECT_EQ(ErrorReason(coordinator_->AddMesh("set", mesh).status()), "BAD_NAME");
}

/// Remembers what it hears.
class Listener final : public JobObserver {
 public:
  void OnJobChanged(const Job& job) override { heard.push_back(job); }
  std::vector<Job> heard;
};

TEST_F(CoordinatorTest, ObserversHearEveryChangeWithGrowingVersions) {
  Listener listener;
  coordinator_->SetObserver(&listener);
  AddScans(2, 1);
  const Job job = Submit();
  Work("w");
  ASSERT_FALSE(listener.heard.empty());
  for (size_t i = 1; i < listener.heard.size(); ++i) {
    EXPECT_GT(listener.heard[i].version, listener.heard[i - 1].version);
    EXPECT_GE(listener.heard[i].progress.tasks_done, listener.heard[i - 1].progress.tasks_done);
  }
  EXPECT_EQ(listener.heard.back().state, JobState::kSucceeded);
  EXPECT_EQ(listener.heard.back().id, job.id);
}

}  // namespace
}  // namespace cohort
