// Results that carry their worker's next report: what is taken and what is given, in one call.
#include <string>

#include <gmock/gmock.h>

#include "tests/server/core/coordinator_fixture.h"
#include "tests/testing/file_size_limit.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

class CarriedReportTest : public CoordinatorTest {
 protected:
  /// Do, with a result that carries the worker's next report.
  absl::StatusOr<CompletionAnswer> DoAndAsk(const std::string& worker,
                                            const GrantedTask& granted,
                                            int free_slots,
                                            bool draining = false) {
    MeshCache cache(store_, 1 << 20);
    TaskRunner runner(store_, cache);
    const WorkerReport next{.worker = WorkerId{worker},
                            .build = "1",
                            .held = {},
                            .free_slots = free_slots,
                            .draining = draining};
    return coordinator_->CompleteTask(WorkerId{worker}, granted.lease,
                                      *runner.Run(granted.task, {}), next, [] { return false; });
  }
};

TEST_F(CarriedReportTest, AResultIsWrittenTogetherWithWhatItsWorkerIsGivenNext) {
  AddScans(4, 1);
  Submit();
  const auto first = Take("w", 1);
  const int64_t writes = catalog_->WriteTimes().Count();
  const auto answer = DoAndAsk("w", first[0], 1);
  ASSERT_THAT(answer, IsOk());
  EXPECT_EQ(catalog_->WriteTimes().Count(), writes + 1);
  EXPECT_TRUE(answer->taken);
  ASSERT_EQ(answer->orders->grants.size(), 1U);
  EXPECT_GT(answer->orders->lease_seconds, 0);
  Restart();
  const GrantedTask next = answer->orders->grants[0];
  for (const GrantedTask& other : Take("other", 9)) {
    EXPECT_NE(other.lease.task, next.lease.task) << "its worker may still do it";
    EXPECT_NE(other.lease.task, first[0].lease.task) << "it is done";
  }
  EXPECT_EQ(*Do("w", first[0]), false);
  EXPECT_EQ(*Do("w", next), true);
}

TEST_F(CarriedReportTest, AJobRunsToItsEndOnReportsThatResultsCarry) {
  AddScans(3, 1);
  const Job calm = Submit();
  const int tasks = Work("w");
  const Job job = Submit();
  int done = 0;
  auto held = Take("w", 1);
  while (!held.empty()) {
    const auto answer = DoAndAsk("w", held[0], 1);
    ASSERT_THAT(answer, IsOk());
    ASSERT_TRUE(answer->orders.has_value());
    held = answer->orders->grants;
    ++done;
  }
  EXPECT_EQ(done, tasks);
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
  EXPECT_EQ(coordinator_->GetOutputs(job.id)->tiles, coordinator_->GetOutputs(calm.id)->tiles);
}

TEST_F(CarriedReportTest, ALateResultIsNotForgottenByAGrantOfItsTask) {
  AddScans(6, 1);
  const Job job = Submit();
  const auto slow = Take("slow", 1);
  clock_.Advance(kLeaseSeconds + 1);
  ASSERT_THAT(coordinator_->Tick(), IsOk());  // The task is ready again.
  const auto answer = DoAndAsk("slow", slow[0], 1);
  ASSERT_THAT(answer, IsOk());
  EXPECT_TRUE(answer->taken);
  ASSERT_EQ(answer->orders->grants.size(), 1U);
  EXPECT_NE(answer->orders->grants[0].lease.task, slow[0].lease.task);
  Restart();
  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_done, 1);
  EXPECT_EQ(*Do("slow", slow[0]), false);
}

TEST_F(CarriedReportTest, AWorkerThatDrainsOrHasNoFreeSlotIsGivenNothingWithItsResult) {
  AddScans(4, 1);
  Submit();
  const auto held = Take("w", 2);
  const auto full = DoAndAsk("w", held[0], 0);
  ASSERT_THAT(full, IsOk());
  EXPECT_TRUE(full->orders->grants.empty());
  const auto draining = DoAndAsk("w", held[1], 1, true);
  ASSERT_THAT(draining, IsOk());
  EXPECT_TRUE(draining->taken);
  EXPECT_TRUE(draining->orders->grants.empty());
  EXPECT_TRUE(coordinator_->ListWorkers()[0].is_draining);
}

TEST_F(CarriedReportTest, WhatCannotBeWrittenIsNeitherTakenNorGiven) {
  AddScans(4, 1);
  const Job job = Submit();
  const auto held = Take("w", 1);
  {
    const testing::FileSizeLimit no_more(0);
    EXPECT_THAT(DoAndAsk("w", held[0], 1), StatusIs(absl::StatusCode::kUnavailable, ""));
  }
  EXPECT_EQ(coordinator_->GetJob(job.id)->progress.tasks_done, 0);
  const auto answer = DoAndAsk("w", held[0], 1);
  ASSERT_THAT(answer, IsOk());
  EXPECT_TRUE(answer->taken);
  ASSERT_EQ(answer->orders->grants.size(), 1U);
  EXPECT_EQ(*Do("w", answer->orders->grants[0]), true);
  // Nothing was left behind with a lease that nobody has.
  Work("w");
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded);
}

}  // namespace
}  // namespace cohort
