// To whom the scheduler gives which task, and from whom it takes one back.
#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/scheduling/scheduler.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const JobId kA{"j-a"};
const JobId kB{"j-b"};
const WorkerId kAnna{"anna"};
const WorkerId kBert{"bert"};
constexpr SchedulerOptions kOptions{.lease_seconds = 1000,
                                    .max_failures = 3,
                                    .max_losses = 2,
                                    .retry_seconds = 1,
                                    .stall_seconds = 100,
                                    .evict_seconds = 60,
                                    .copy_factor = 2,
                                    .least_copy_seconds = 5};

MonotonicTime At(double seconds) {
  return MonotonicTime() + std::chrono::duration_cast<MonotonicTime::duration>(
                               std::chrono::duration<double>(seconds));
}

Lease L(const JobId& job, int64_t number, int64_t epoch) {
  return {{job, number}, epoch};
}

/// Five tasks of about ten seconds done by Anna, then one more that she has since At(100).
Scheduler WithOneTaskOut() {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 6);
  for (int64_t number = 0; number < 5; ++number) {
    const double start = 10.0 * static_cast<double>(number);
    EXPECT_THAT(scheduler.Grant(kAnna, 1, At(start)), ElementsAre(L(kA, number, 1)));
    EXPECT_EQ(scheduler.Complete(L(kA, number, 1), At(start + 10)), CompletionVerdict::kAccepted);
  }
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(100)), ElementsAre(L(kA, 5, 1)));
  (void)scheduler.Renew(kAnna, {{L(kA, 5, 1), 1}}, At(100));
  return scheduler;
}

TEST(SchedulerCopies, RunASecondTimeWhatTakesTooLongWhenNothingElseIsLeft) {
  Scheduler scheduler = WithOneTaskOut();
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(118)), IsEmpty()) << "not slow yet";
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(125)), IsEmpty()) << "its own worker";
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(125)), ElementsAre(L(kA, 5, 2)));
  EXPECT_THAT(scheduler.Grant({"carl"}, 1, At(500)), IsEmpty()) << "no third copy";
  EXPECT_EQ(scheduler.LeasedCount(), 1) << "one task";
  EXPECT_TRUE(scheduler.IsCurrent(L(kA, 5, 1)) && scheduler.IsCurrent(L(kA, 5, 2)));
  EXPECT_EQ(scheduler.Complete(L(kA, 5, 1), At(130)), CompletionVerdict::kAccepted);
  EXPECT_THAT(scheduler.Renew(kBert, {{L(kA, 5, 2), 3}}, At(131)).lost, ElementsAre(L(kA, 5, 2)));
  EXPECT_EQ(scheduler.Complete(L(kA, 5, 2), At(132)), CompletionVerdict::kDuplicate);
}

TEST(SchedulerCopies, GoOnWhenTheOtherIsLostOrFails) {
  Scheduler scheduler = WithOneTaskOut();
  ASSERT_THAT(scheduler.Grant(kBert, 1, At(125)), ElementsAre(L(kA, 5, 2)));
  EXPECT_FALSE(scheduler.Fail(L(kA, 5, 2), true, At(126)));
  EXPECT_EQ(scheduler.LeaseOf({kA, 5}), L(kA, 5, 1));
  ASSERT_THAT(scheduler.Grant(kBert, 1, At(127)), ElementsAre(L(kA, 5, 3)));
  EXPECT_THAT(scheduler.Expire(At(1100)), IsEmpty());  // Anna's ran out, Bert's not.
  EXPECT_EQ(scheduler.LeaseOf({kA, 5}), L(kA, 5, 3));
  EXPECT_EQ(scheduler.AttemptsOf({kA, 5}).losses, 1);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 5}).failures, 1);
}

TEST(SchedulerCopies, TakeWhatAnotherWorkerHasNotBegun) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 2);
  const auto leases = scheduler.Grant(kAnna, 2, At(0));
  (void)scheduler.Renew(kAnna, {{leases[0], 7}, {leases[1], HeldTask::kNotBegun}}, At(0.5));
  EXPECT_THAT(scheduler.Grant(kBert, 2, At(0.9)), IsEmpty());
  EXPECT_THAT(scheduler.Grant(kBert, 2, At(1.1)), ElementsAre(L(kA, 1, 2)));
}

TEST(SchedulerUnheard, AGrantThatItsWorkerNeverListsIsFreeAgainAndCountsAsNothing) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 1);
  const Lease lost = scheduler.Grant(kAnna, 1, At(0))[0];
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(4.9)), IsEmpty()) << "it may be on its way";
  EXPECT_THAT(scheduler.TakeBackUnheard(kBert, At(5)), IsEmpty()) << "another's report";
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(5)), ElementsAre(lost));
  EXPECT_FALSE(scheduler.IsCurrent(lost));
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 0);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).failures, 0);
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(5)), ElementsAre(L(kA, 0, 2)));
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(99)), IsEmpty());
}

TEST(SchedulerUnheard, WhatWasListedOnceStaysWithItsWorker) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 2);
  const auto leases = scheduler.Grant(kAnna, 2, At(0));
  EXPECT_THAT(scheduler.Renew(kAnna, {{leases[0], HeldTask::kNotBegun}}, At(1)).lost, IsEmpty());
  // Its result is on the way, in the call that brings this report.
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(30)), ElementsAre(leases[1]));
  EXPECT_TRUE(scheduler.IsCurrent(leases[0]));
}

TEST(SchedulerUnheard, ARestartedServerWaitsForItsWorkersAnew) {
  Scheduler scheduler(kOptions);
  scheduler.RestoreLease({kA, 0}, {.epoch = 3}, kAnna, At(100));
  scheduler.RestoreLease({kA, 1}, {.epoch = 1}, kAnna, At(100));
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(104)), IsEmpty());
  (void)scheduler.Renew(kAnna, {{L(kA, 0, 3), 1}}, At(105));
  EXPECT_THAT(scheduler.TakeBackUnheard(kAnna, At(105)), ElementsAre(L(kA, 1, 1)));
}

TEST(SchedulerUnheard, OfASecondCopyTheFirstGoesOn) {
  Scheduler scheduler = WithOneTaskOut();
  ASSERT_THAT(scheduler.Grant(kBert, 1, At(125)), ElementsAre(L(kA, 5, 2)));
  EXPECT_THAT(scheduler.TakeBackUnheard(kBert, At(130)), ElementsAre(L(kA, 5, 2)));
  EXPECT_EQ(scheduler.LeaseOf({kA, 5}), L(kA, 5, 1));
  scheduler.RemoveJob(kA);
  EXPECT_THAT(scheduler.TakeBackUnheard(kBert, At(999)), IsEmpty());
}

TEST(SchedulerRenew, TakesBackATaskThatDoesNotGetOn) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 1);
  const Lease lease = scheduler.Grant(kAnna, 1, At(0))[0];
  EXPECT_THAT(scheduler.Renew(kAnna, {{lease, 5}}, At(10)).lost, IsEmpty());
  EXPECT_THAT(scheduler.Renew(kAnna, {{lease, 6}}, At(100)).lost, IsEmpty());
  EXPECT_THAT(scheduler.Renew(kAnna, {{lease, 6}}, At(199)).lost, IsEmpty());
  const Renewal stalled = scheduler.Renew(kAnna, {{lease, 6}}, At(200));
  EXPECT_THAT(stalled.lost, ElementsAre(lease));
  EXPECT_FALSE(stalled.is_wedged);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 1);
  EXPECT_FALSE(scheduler.Renew(kAnna, {{lease, 6}}, At(259)).is_wedged);
  EXPECT_TRUE(scheduler.Renew(kAnna, {{lease, 6}}, At(260)).is_wedged);
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(260)), ElementsAre(L(kA, 0, 2)));
}

TEST(SchedulerRenew, GivesUpATaskThatStallsEverywhere) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 1);
  for (int64_t epoch = 1; epoch <= kOptions.max_losses; ++epoch) {
    const double start = 1000.0 * static_cast<double>(epoch);
    ASSERT_THAT(scheduler.Grant(kAnna, 1, At(start)), ElementsAre(L(kA, 0, epoch)));
    (void)scheduler.Renew(kAnna, {{L(kA, 0, epoch), 1}}, At(start));
    const Renewal stalled = scheduler.Renew(kAnna, {{L(kA, 0, epoch), 1}}, At(start + 100));
    EXPECT_EQ(stalled.given_up.size(), epoch == kOptions.max_losses ? 1U : 0U);
  }
  EXPECT_EQ(scheduler.OpenCount(kA), 0);
}

TEST(SchedulerExpire, DoesNotHoldAgainstATaskThatItWasNotBegun) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 1);
  for (int round = 0; round < 10; ++round) {
    const double start = 3000.0 * round;
    const Lease lease = scheduler.Grant(kAnna, 1, At(start))[0];
    (void)scheduler.Renew(kAnna, {{lease, HeldTask::kNotBegun}}, At(start));
    EXPECT_THAT(scheduler.Expire(At(start + 1000)), IsEmpty());
  }
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 0);
}

TEST(SchedulerJobs, OfHigherPriorityComeFirst) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 9);
  scheduler.AddTasks(kB, 0, 2);
  scheduler.SetJob(kB, {.priority = 1, .is_paused = false, .traits_of = nullptr});
  EXPECT_THAT(scheduler.Grant(kAnna, 3, At(0)), ElementsAre(L(kB, 0, 1), L(kB, 1, 1), L(kA, 0, 1)));
}

TEST(SchedulerJobs, ThatArePausedGetNothingButKeepWhatIsOut) {
  Scheduler scheduler(kOptions);
  scheduler.AddTasks(kA, 0, 3);
  const Lease lease = scheduler.Grant(kAnna, 1, At(0))[0];
  scheduler.SetJob(kA, {.priority = 0, .is_paused = true, .traits_of = nullptr});
  EXPECT_FALSE(scheduler.HasReadyTask(At(0)));
  EXPECT_EQ(scheduler.ReadyCount(), 2);
  EXPECT_EQ(scheduler.GrantableCount(), 0);
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(500)), IsEmpty());
  EXPECT_THAT(scheduler.Renew(kAnna, {{lease, 1}}, At(500)).lost, IsEmpty());
  EXPECT_FALSE(scheduler.Fail(lease, true, At(500)));
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(600)), IsEmpty()) << "also after the back-off";
  scheduler.SetJob(kA, {});
  EXPECT_THAT(scheduler.Grant(kBert, 9, At(600)),
              ElementsAre(L(kA, 0, 2), L(kA, 1, 1), L(kA, 2, 1)));
}

TEST(SchedulerLocality, KeepsToTheStageThatComesFirst) {
  Scheduler scheduler(kOptions);
  const auto traits_of = [](int64_t number) {
    return TaskTraits{.stage = number / 3, .reads = {number % 3, TaskTraits::kNothing}};
  };
  scheduler.SetJob(kA, {.priority = 0, .is_paused = false, .traits_of = traits_of});
  scheduler.AddTasks(kA, 0, 6);
  // Task 3 reads what Anna has read for task 0, but is of the next stage.
  EXPECT_THAT(scheduler.Grant(kAnna, 4, At(0)),
              ElementsAre(L(kA, 0, 1), L(kA, 1, 1), L(kA, 2, 1), L(kA, 3, 1)));
}

TEST(SchedulerLocality, GivesAWorkerWhatReadsTheSameMeshes) {
  Scheduler scheduler(kOptions);
  // A table of 6 x 6 tiles, row by row.
  const auto traits_of = [](int64_t number) {
    return TaskTraits{.stage = 0, .reads = {number / 6, number % 6}};
  };
  scheduler.SetJob(kA, {.priority = 0, .is_paused = false, .traits_of = traits_of});
  scheduler.AddTasks(kA, 0, 36);
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 0, 1)));   // Row 0, column 0.
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(0)), ElementsAre(L(kA, 1, 1)));   // 0 and 1.
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(0)), ElementsAre(L(kA, 6, 1)));   // 1 and 0: has both.
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(0)), ElementsAre(L(kA, 7, 1)));   // 1 and 1.
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 2, 1)));   // 0 and 2.
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 12, 1)));  // 2 and 0.
}

TEST(SchedulerLocality, LeavesSmallTasksForTheEnd) {
  Scheduler scheduler(kOptions);
  const std::vector<double> costs = {4, 1, 4, 3, 4, 1};
  const auto traits_of = [&](int64_t number) {
    return TaskTraits{.stage = 0,
                      .reads = {number % 2, TaskTraits::kNothing},
                      .cost = costs[static_cast<size_t>(number)]};
  };
  scheduler.SetJob(kA, {.priority = 0, .is_paused = false, .traits_of = traits_of});
  scheduler.AddTasks(kA, 0, 6);
  EXPECT_THAT(scheduler.Grant(kAnna, 3, At(0)), ElementsAre(L(kA, 0, 1), L(kA, 2, 1), L(kA, 4, 1)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 3, 1)))
      << "costs 3: others of her group, of 1, wait";
  EXPECT_THAT(scheduler.Grant(kAnna, 2, At(0)), ElementsAre(L(kA, 1, 1), L(kA, 5, 1)));
}

}  // namespace
}  // namespace cohort
