#include "server/scheduling/scheduler.h"

#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const JobId kA{"j-a"};
const JobId kB{"j-b"};
const JobId kC{"j-c"};
const WorkerId kAnna{"anna"};
const WorkerId kBert{"bert"};
constexpr SchedulerOptions kOptions{
    .lease_seconds = 60, .max_failures = 3, .max_losses = 4, .retry_seconds = 1};

MonotonicTime At(double seconds) {
  return MonotonicTime() + std::chrono::duration_cast<MonotonicTime::duration>(
                               std::chrono::duration<double>(seconds));
}

Lease L(const JobId& job, int64_t number, int64_t epoch) {
  return {{job, number}, epoch};
}

/// The leases that a worker has lost, told that all of them get on.
std::vector<Lease> Renew(Scheduler& scheduler,
                         const WorkerId& worker,
                         const std::vector<Lease>& leases,
                         MonotonicTime now) {
  static int64_t ticks = 0;
  std::vector<HeldTask> held;
  held.reserve(leases.size());
  for (const Lease& lease : leases) {
    held.push_back({.lease = lease, .ticks = ++ticks});
  }
  return scheduler.Renew(worker, held, now).lost;
}

Scheduler WithTasks(const JobId& job, int64_t count) {
  Scheduler scheduler(kOptions);
  for (int64_t number = 0; number < count; ++number) {
    scheduler.AddTask({job, number});
  }
  return scheduler;
}

TEST(SchedulerGrant, HandsOutTasksInNumberOrderHoweverTheyCame) {
  Scheduler scheduler(kOptions);
  for (const int64_t number : {5, 2, 9}) {
    scheduler.AddTask({kA, number});
  }
  EXPECT_EQ(scheduler.ReadyCount(), 3);
  EXPECT_EQ(scheduler.GrantableCount(), 3);
  EXPECT_THAT(scheduler.Grant(kAnna, 2, At(0)), ElementsAre(L(kA, 2, 1), L(kA, 5, 1)));
  EXPECT_EQ(scheduler.ReadyCount(), 1);
  EXPECT_EQ(scheduler.LeasedCount(), 2);
  EXPECT_THAT(scheduler.Grant(kBert, 5, At(0)), ElementsAre(L(kA, 9, 1)));
  EXPECT_THAT(scheduler.Grant(kBert, 5, At(0)), IsEmpty());
  EXPECT_FALSE(scheduler.HasReadyTask(At(0)));
}

TEST(SchedulerGrant, GivesNothingForNoSlots) {
  Scheduler scheduler = WithTasks(kA, 1);
  EXPECT_THAT(scheduler.Grant(kAnna, 0, At(0)), IsEmpty());
  EXPECT_THAT(scheduler.Grant(kAnna, -1, At(0)), IsEmpty());
  EXPECT_TRUE(scheduler.HasReadyTask(At(0)));
}

TEST(SchedulerGrant, LetsJobsTakeTurnsWithinOneGrant) {
  Scheduler scheduler = WithTasks(kA, 3);
  scheduler.AddTask({kB, 0});
  scheduler.AddTask({kC, 0});
  scheduler.AddTask({kC, 1});
  EXPECT_THAT(scheduler.Grant(kAnna, 6, At(0)), ElementsAre(L(kA, 0, 1), L(kB, 0, 1), L(kC, 0, 1),
                                                            L(kA, 1, 1), L(kC, 1, 1), L(kA, 2, 1)));
}

TEST(SchedulerGrant, LetsJobsTakeTurnsOverSeveralGrants) {
  Scheduler scheduler = WithTasks(kA, 1000);
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 0, 1)));
  scheduler.AddTask({kB, 0});
  scheduler.AddTask({kB, 1});
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kB, 0, 1)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 1, 1)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kB, 1, 1)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 2, 1)));
}

TEST(SchedulerAddTask, LeavesATaskAloneThatIsThere) {
  Scheduler scheduler = WithTasks(kA, 1);
  const std::vector<Lease> leases = scheduler.Grant(kAnna, 1, At(0));
  scheduler.AddTask({kA, 0});
  EXPECT_EQ(scheduler.ReadyCount(), 0);
  EXPECT_EQ(scheduler.LeaseOf({kA, 0}), leases[0]);
}

TEST(SchedulerAddTask, GoesOnFromTheAttemptsThatTheCatalogKept) {
  Scheduler scheduler(kOptions);
  scheduler.AddTask({kA, 0}, {.epoch = 7, .failures = 2, .losses = 1});
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(0)), ElementsAre(L(kA, 0, 8)));
  EXPECT_TRUE(scheduler.Fail(L(kA, 0, 8), true, At(0))) << "the third failure";
}

TEST(SchedulerExpire, TakesBackALeaseOnlyWhenItRanOut) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  EXPECT_THAT(scheduler.Expire(At(59.9)), IsEmpty());
  EXPECT_EQ(scheduler.LeasedCount(), 1);
  EXPECT_THAT(scheduler.Expire(At(60)), IsEmpty());
  EXPECT_EQ(scheduler.LeasedCount(), 0);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 1);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).failures, 0);
  EXPECT_EQ(scheduler.LeaseOf({kA, 0}), std::nullopt);
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(60)), ElementsAre(L(kA, 0, 2)));
}

TEST(SchedulerExpire, GivesATaskUpThatLostTooManyWorkers) {
  Scheduler scheduler = WithTasks(kA, 2);
  for (int loss = 1; loss < kOptions.max_losses; ++loss) {
    ASSERT_EQ(scheduler.Grant(kAnna, 2, At(100 * loss)).size(), 2u);
    EXPECT_THAT(scheduler.Expire(At(100 * loss + 60)), IsEmpty());
  }
  (void)scheduler.Grant(kAnna, 1, At(1000));
  EXPECT_THAT(scheduler.Expire(At(1060)), ElementsAre(TaskId{kA, 0}));
  EXPECT_THAT(scheduler.Grant(kAnna, 5, At(1060)), ElementsAre(L(kA, 1, 4)));
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 4), At(0)), CompletionVerdict::kNotActive);
}

TEST(SchedulerRenew, KeepsALeaseAlive) {
  Scheduler scheduler = WithTasks(kA, 1);
  const std::vector<Lease> held = scheduler.Grant(kAnna, 1, At(0));
  EXPECT_THAT(Renew(scheduler, kAnna, held, At(50)), IsEmpty());
  EXPECT_THAT(scheduler.Expire(At(109)), IsEmpty());
  EXPECT_EQ(scheduler.LeasedCount(), 1);
  (void)scheduler.Expire(At(110));
  EXPECT_EQ(scheduler.LeasedCount(), 0);
}

TEST(SchedulerRenew, NamesTheLeasesThatAreGone) {
  Scheduler scheduler = WithTasks(kA, 5);
  scheduler.AddTask({kB, 0});
  const std::vector<Lease> held = scheduler.Grant(kAnna, 6, At(0));
  ASSERT_EQ(held.size(), 6u);
  (void)Renew(scheduler, kAnna, {L(kA, 0, 1), L(kA, 3, 1), L(kA, 4, 1)}, At(30));
  (void)scheduler.Expire(At(60));           // Task 1 and 2 of A run out, and B's.
  (void)scheduler.Grant(kBert, 1, At(60));  // Task 1 goes to Bert, epoch 2.
  (void)scheduler.Complete(L(kA, 3, 1), At(0));
  scheduler.RemoveJob(kB);
  EXPECT_THAT(Renew(scheduler, kAnna, held, At(61)),
              ElementsAre(L(kB, 0, 1), L(kA, 1, 1), L(kA, 2, 1), L(kA, 3, 1)));
  EXPECT_THAT(Renew(scheduler, kBert, {L(kA, 0, 1)}, At(61)), ElementsAre(L(kA, 0, 1)))
      << "the lease of another worker";
}

TEST(SchedulerComplete, TakesTheFirstResultAndKnowsTheSecond) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 1), At(0)), CompletionVerdict::kAccepted);
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 1), At(0)), CompletionVerdict::kDuplicate);
  EXPECT_EQ(scheduler.LeasedCount(), 0);
  EXPECT_THAT(scheduler.Expire(At(1000)), IsEmpty());
  EXPECT_FALSE(scheduler.HasReadyTask(At(1000)));
}

TEST(SchedulerComplete, TakesTheLateResultOfAnExpiredLease) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  (void)scheduler.Expire(At(60));
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 1), At(0)), CompletionVerdict::kAccepted);
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(60)), IsEmpty());
}

TEST(SchedulerComplete, TakesALateResultWhileAnotherWorkerRunsTheTask) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  (void)scheduler.Expire(At(60));
  const std::vector<Lease> second = scheduler.Grant(kBert, 1, At(60));
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 1), At(0)), CompletionVerdict::kAccepted);
  EXPECT_EQ(Renew(scheduler, kBert, second, At(61)), second) << "Bert is told to stop";
  EXPECT_EQ(scheduler.Complete(second[0], At(0)), CompletionVerdict::kDuplicate);
}

TEST(SchedulerComplete, RefusesWhatIsNotActive) {
  Scheduler scheduler = WithTasks(kA, 1);
  EXPECT_EQ(scheduler.Complete(L(kA, 1, 1), At(0)), CompletionVerdict::kNotActive);
  EXPECT_EQ(scheduler.Complete(L(kB, 0, 1), At(0)), CompletionVerdict::kNotActive);
}

TEST(SchedulerRelease, IsNoFailureAndNoLoss) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  EXPECT_TRUE(scheduler.Release(L(kA, 0, 1), At(1)));
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).failures, 0);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 0);
  EXPECT_FALSE(scheduler.Release(L(kA, 0, 1), At(1))) << "stale by now";
  EXPECT_THAT(scheduler.Grant(kBert, 1, At(1)), ElementsAre(L(kA, 0, 2)));
  EXPECT_FALSE(scheduler.Release(L(kA, 0, 1), At(1))) << "the lease of before";
  EXPECT_EQ(scheduler.LeasedCount(), 1);
}

TEST(SchedulerFail, WaitsTwiceAsLongAfterEachFailure) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  EXPECT_FALSE(scheduler.Fail(L(kA, 0, 1), true, At(10)));
  EXPECT_FALSE(scheduler.HasReadyTask(At(10.9)));
  EXPECT_EQ(scheduler.ReadyCount(), 1);
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(10.9)), IsEmpty());
  EXPECT_TRUE(scheduler.HasReadyTask(At(11)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(11)), ElementsAre(L(kA, 0, 2)));
  EXPECT_FALSE(scheduler.Fail(L(kA, 0, 2), true, At(20)));
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(21.9)), IsEmpty());
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(22)), ElementsAre(L(kA, 0, 3)));
  EXPECT_TRUE(scheduler.Fail(L(kA, 0, 3), true, At(30))) << "max_failures = 3";
  EXPECT_THAT(scheduler.Grant(kAnna, 1, At(1000)), IsEmpty());
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).failures, 3);
}

TEST(SchedulerFail, GivesUpAtOnceWhenARetryCannotHelp) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  EXPECT_TRUE(scheduler.Fail(L(kA, 0, 1), false, At(0)));
  EXPECT_FALSE(scheduler.HasReadyTask(At(1000)));
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 1), At(0)), CompletionVerdict::kNotActive);
}

TEST(SchedulerFail, IgnoresAStaleLease) {
  Scheduler scheduler = WithTasks(kA, 1);
  (void)scheduler.Grant(kAnna, 1, At(0));
  (void)scheduler.Expire(At(60));
  (void)scheduler.Grant(kBert, 1, At(60));
  EXPECT_FALSE(scheduler.Fail(L(kA, 0, 1), false, At(61)));
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).failures, 0);
  EXPECT_EQ(scheduler.LeaseOf({kA, 0}), L(kA, 0, 2));
}

TEST(SchedulerRemoveJob, ForgetsTasksInEveryState) {
  Scheduler scheduler = WithTasks(kA, 4);
  (void)scheduler.Grant(kAnna, 3, At(0));
  (void)scheduler.Complete(L(kA, 0, 1), At(0));
  (void)scheduler.Fail(L(kA, 1, 1), true, At(0));
  scheduler.AddTask({kB, 0});
  scheduler.RemoveJob(kA);
  scheduler.RemoveJob(kA);
  EXPECT_EQ(scheduler.ReadyCount(), 1);
  EXPECT_EQ(scheduler.LeasedCount(), 0);
  EXPECT_THAT(scheduler.Expire(At(1000)), IsEmpty());
  EXPECT_EQ(scheduler.Complete(L(kA, 2, 1), At(0)), CompletionVerdict::kNotActive);
  EXPECT_FALSE(scheduler.Release(L(kA, 2, 1), At(0)));
  EXPECT_FALSE(scheduler.Fail(L(kA, 2, 1), true, At(0)));
  EXPECT_THAT(scheduler.Grant(kAnna, 9, At(1000)), ElementsAre(L(kB, 0, 1)));
}

TEST(SchedulerRestoreLease, GivesTheWorkerOneLeaseTimeToReport) {
  Scheduler scheduler(kOptions);
  scheduler.RestoreLease({kA, 0}, {.epoch = 3, .failures = 1, .losses = 2}, kAnna, At(500));
  scheduler.RestoreLease({kA, 1}, {.epoch = 1, .failures = 0, .losses = 0}, kBert, At(500));
  EXPECT_FALSE(scheduler.HasReadyTask(At(500)));
  EXPECT_EQ(scheduler.LeaseOf({kA, 0}), L(kA, 0, 3));
  EXPECT_THAT(Renew(scheduler, kAnna, {L(kA, 0, 3)}, At(559)), IsEmpty());
  EXPECT_THAT(scheduler.Expire(At(560)), IsEmpty());
  EXPECT_THAT(scheduler.Grant(kAnna, 9, At(560)), ElementsAre(L(kA, 1, 2)));
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).losses, 2);
  EXPECT_EQ(scheduler.Complete(L(kA, 0, 3), At(0)), CompletionVerdict::kAccepted);
}

TEST(Scheduler, KnowsNothingOfUnknownTasks) {
  const Scheduler scheduler(kOptions);
  EXPECT_EQ(scheduler.AttemptsOf({kA, 0}).epoch, 0);
  EXPECT_EQ(scheduler.LeaseOf({kA, 0}), std::nullopt);
  EXPECT_EQ(scheduler.ReadyCount(), 0);
}

// Work per grant must not grow with the number of tasks: quadratic, this would take minutes.
TEST(Scheduler, ServesAHundredThousandTasks) {
  Scheduler scheduler = WithTasks(kA, 100000);
  int64_t done = 0;
  for (double seconds = 0; done < 100000; ++seconds) {
    for (const Lease& lease : scheduler.Grant(kAnna, 64, At(seconds))) {
      ASSERT_EQ(scheduler.Complete(lease, At(0)), CompletionVerdict::kAccepted);
      ++done;
    }
  }
  EXPECT_EQ(scheduler.ReadyCount(), 0);
}

}  // namespace
}  // namespace cohort
