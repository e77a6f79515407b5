// Jobs that a cohort-server of another version began or finished.
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/core/store_fixture.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

class OtherVersionsTest : public testing::StoreFixture {
 protected:
  static JobSpec Spec() {
    JobSpec spec;
    spec.rounds = 1;
    spec.icp.max_iterations = 3;
    return spec;
  }
  /// What a calm run of the job gives.
  std::string CalmOutputs() {
    const Job calm = Submit(Spec(), true);
    Work();
    return OutputsOf(calm);
  }
  void WorkOn(int tasks) {
    int done = 0;
    Work([&](const testing::DoneTask&) { return ++done == tasks; });
  }
  /// As if the other version had numbered its tasks in another way: each result but those of ingest
  /// is under the number of the next task of its stage.
  void MixUpResults(const Job& job) {
    std::vector<TaskRecord> done;
    ASSERT_THAT(catalog_->VisitTasks(job.id,
                                     [&](const TaskRecord& record) {
                                       if (record.result && record.result->ingested.empty()) {
                                         done.push_back(record);
                                       }
                                       return absl::OkStatus();
                                     }),
                IsOk());
    ASSERT_GE(done.size(), 2u);
    std::vector<JobTask> mixed;
    for (size_t i = 0; i < done.size(); ++i) {
      mixed.push_back({.job = job.id, .task = done[i]});
      mixed.back().task.result = done[(i + 1) % done.size()].result;
    }
    ASSERT_THAT(catalog_->SaveTasks(mixed, {}), IsOk());
  }
};

TEST_F(OtherVersionsTest, ResultsUnderTheNumbersOfAnotherPlanAreNotTaken) {
  const std::string expected = CalmOutputs();
  const Job job = Submit(Spec(), true);
  WorkOn(5);
  MixUpResults(job);
  ++options_.plan_version;

  Restart();
  Work();

  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  EXPECT_EQ(OutputsOf(job), expected);
}

TEST_F(OtherVersionsTest, WhatBothPlansShareIsNotComputedAgain) {
  const Job job = Submit(Spec(), false);
  WorkOn(5);
  ++options_.plan_version;

  Restart();
  const int64_t rest = std::ssize(Work());

  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_total, 5 + rest);
  const Job calm = Submit(Spec(), true);
  Work();
  EXPECT_EQ(OutputsOf(job), OutputsOf(calm));
  EXPECT_EQ(coordinator_->GetJob(job.id)->counters, coordinator_->GetJob(calm.id)->counters);
}

TEST_F(OtherVersionsTest, AWorkersResultOfAnEarlierPlanIsNotTaken) {
  const Job job = Submit(Spec(), true);
  WorkOn(3);
  const std::vector<GrantedTask> held = Take(1);
  ASSERT_EQ(held.size(), 1u);
  MeshCache cache(*store_, 1 << 20);
  const auto result = TaskRunner(*store_, cache).Run(held[0].task, {});
  ASSERT_THAT(result, IsOk());
  ++options_.plan_version;

  Restart();

  EXPECT_THAT(coordinator_->CompleteTask(WorkerId{"w"}, held[0].lease, *result),
              IsOkAndHolds(false));
  Work();
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
}

TEST_F(OtherVersionsTest, IsStartedOverOnceOnly) {
  const Job job = Submit(Spec(), true);
  WorkOn(5);
  ++options_.plan_version;
  Restart();
  WorkOn(2);
  const int64_t done = coordinator_->GetJob(job.id)->progress.tasks_done;

  Restart();

  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_done, done);
}

TEST_F(OtherVersionsTest, AJobWhoseResultsWouldBeOthersIsStartedOver) {
  const std::string expected = CalmOutputs();
  const Job job = Submit(Spec(), true);
  WorkOn(5);
  MixUpResults(job);
  ++options_.results_version;

  Restart();
  Work();

  EXPECT_EQ(OutputsOf(job), expected);
}

TEST_F(OtherVersionsTest, AFinishedJobStaysAsItIs) {
  const Job job = Submit(Spec(), false);
  Work();
  const std::string outputs = OutputsOf(job);
  ++options_.plan_version;
  ++options_.results_version;

  Restart();

  EXPECT_EQ(OutputsOf(job), outputs);
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  EXPECT_TRUE(Work().empty());
}

TEST_F(OtherVersionsTest, ALostBlobOfAFinishedJobIsMadeAgainByOurPlan) {
  const Job job = Submit(Spec(), false);
  Work();
  const std::string outputs = OutputsOf(job);
  MixUpResults(job);
  Spoil(coordinator_->GetOutputs(job.id)->mean_shape, Damage::kDeleted);
  ++options_.plan_version;
  Restart();

  ASSERT_THAT(coordinator_->RetryJob(job.id), IsOk());
  Work();

  EXPECT_EQ(OutputsOf(job), outputs);
}

TEST_F(OtherVersionsTest, DistancesOfAnotherVersionAreNotAddedTo) {
  const Job reference = Submit(Spec(), false);
  Work();
  JobSpec adding;
  adding.reference_job = reference.id.value;
  ++options_.plan_version;
  Restart();
  EXPECT_THAT(coordinator_->CreateJob("set", adding, ""), IsOk()) << "the same results";

  ++options_.results_version;
  Restart();

  EXPECT_THAT(coordinator_->CreateJob("set", adding, ""),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "reference job " + reference.id.value +
                           " was computed by another version of cohort-server"));
}

TEST_F(OtherVersionsTest, AJobInTheMidstOfAddingToDistancesOfAnotherVersionFails) {
  const Job reference = Submit(Spec(), false);
  Work();
  JobSpec adding;
  adding.reference_job = reference.id.value;
  ASSERT_THAT(coordinator_->RemoveMesh("set", meshes_[0].name), IsOk());
  SetMesh renamed = meshes_[0];
  renamed.name = "new.ply";
  ASSERT_THAT(coordinator_->AddMesh("set", renamed), IsOk());
  const Job job = *coordinator_->CreateJob("set", adding, "");
  ASSERT_FALSE(IsFinal(job.state));
  ++options_.results_version;

  Restart();

  const Job failed = *coordinator_->GetJob(job.id);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_THAT(failed.error, ::testing::HasSubstr("submit it without --reference"));
}

}  // namespace
}  // namespace cohort
