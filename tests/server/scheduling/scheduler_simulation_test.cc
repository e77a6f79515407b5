
#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "server/scheduling/scheduler.h"

namespace cohort {
namespace {

constexpr SchedulerOptions kOptions{
    .lease_seconds = 10, .max_failures = 1000, .max_losses = 1000, .retry_seconds = 0.5};
constexpr int kJobs = 3;
constexpr int kWorkers = 5;
constexpr int kStormSteps = 2000;

// What a test remembers of a task, as the catalog would.
struct TaskTruth {
  TaskAttempts attempts;
  WorkerId worker;
  bool leased = false;
  int accepted = 0;
};

// A server, its catalog and some workers on a bad day. Every step does one random thing; after the
// storm one healthy worker must be able to finish the rest.
class Storm {
 public:
  explicit Storm(uint64_t seed) : random_(seed), scheduler_(kOptions), held_(kWorkers) {
    for (int job = 0; job < kJobs; ++job) {
      for (int64_t number = 1 + random_.Below(20); number > 0; --number) {
        const TaskId task{JobOf(job), number};
        truth_[task];
        scheduler_.AddTask(task);
      }
    }
  }

  void Rage() {
    for (int step = 0; step < kStormSteps; ++step) {
      now_ += std::chrono::milliseconds(random_.Below(500));
      DoOneThing(static_cast<size_t>(random_.Below(kWorkers)));
      CheckCounts();
    }
  }

  // One worker that always renews; the others are gone.
  void Calm() {
    held_.assign(kWorkers, {});
    for (int step = 0; step < 10000 && !AllDone(); ++step) {
      now_ += std::chrono::seconds(1);
      ExpireAll();
      GrantTo(0);
      RenewFor(0);
      if (!held_[0].empty()) {
        CompleteLease(held_[0].front());
        held_[0].erase(held_[0].begin());
      }
    }
  }

  void CheckEnd() {
    for (const auto& [task, truth] : truth_) {
      EXPECT_EQ(truth.accepted, 1) << task.job.value << " task " << task.number;
    }
    EXPECT_EQ(scheduler_.ReadyCount(), 0);
    EXPECT_EQ(scheduler_.LeasedCount(), 0);
  }

 private:
  enum class Fate { kFail, kRelease };
  static JobId JobOf(int job) { return {"j-" + std::to_string(job)}; }
  static WorkerId WorkerOf(size_t worker) { return {"w-" + std::to_string(worker)}; }

  void DoOneThing(size_t worker) {
    switch (random_.Below(12)) {
      case 0:
      case 1:
        GrantTo(worker);
        break;
      case 2:
      case 3:
      case 4:
        RenewFor(worker);
        break;
      case 5:
        if (Lease* lease = AnyHeld(worker)) {
          CompleteLease(*lease);
        }
        break;
      case 6:
        if (Lease* lease = AnyHeld(worker)) {
          Forget(worker, *lease, Fate::kFail);
        }
        break;
      case 7:
        if (Lease* lease = AnyHeld(worker)) {
          Forget(worker, *lease, Fate::kRelease);
        }
        break;
      case 8:
        if (random_.Below(10) == 0) {
          held_[worker].clear();
        }
        break;  // It crashed.
      case 9:
        ExpireAll();
        break;
      case 10:
        if (!past_.empty()) {
          CompleteLease(AnyPast());
        }
        break;  // Late, or twice.
      case 11:
        if (random_.Below(50) == 0) {
          Restart();
        }
        break;
    }
  }

  Lease* AnyHeld(size_t worker) {
    std::vector<Lease>& held = held_[worker];
    return held.empty()
               ? nullptr
               : &held[static_cast<size_t>(random_.Below(static_cast<int64_t>(held.size())))];
  }
  const Lease& AnyPast() {
    return past_[static_cast<size_t>(random_.Below(static_cast<int64_t>(past_.size())))];
  }

  void GrantTo(size_t worker) {
    for (const Lease& lease :
         scheduler_.Grant(WorkerOf(worker), static_cast<int>(1 + random_.Below(3)), now_)) {
      EXPECT_TRUE(granted_.emplace(lease.task, lease.epoch).second) << "the same lease twice";
      TaskTruth& truth = truth_.at(lease.task);
      EXPECT_EQ(truth.accepted, 0) << "granted after it was done";
      EXPECT_FALSE(truth.leased) << "two current leases";
      EXPECT_GT(lease.epoch, truth.attempts.epoch);
      truth.worker = WorkerOf(worker);
      Remember(lease.task);
      held_[worker].push_back(lease);
      past_.push_back(lease);
    }
  }

  void RenewFor(size_t worker) {
    for (const Lease& lost : scheduler_.Renew(WorkerOf(worker), held_[worker], now_)) {
      const TaskTruth& truth = truth_.at(lost.task);
      EXPECT_TRUE(!truth.leased || truth.attempts.epoch != lost.epoch) << "a current lease";
      std::erase(held_[worker], lost);
    }
  }

  void CompleteLease(const Lease& lease) {
    TaskTruth& truth = truth_.at(lease.task);
    const CompletionVerdict verdict = scheduler_.Complete(lease);
    if (truth.accepted == 0) {
      EXPECT_EQ(verdict, CompletionVerdict::kAccepted);
      truth.accepted += verdict == CompletionVerdict::kAccepted ? 1 : 0;
    } else {
      EXPECT_NE(verdict, CompletionVerdict::kAccepted);
    }
    Remember(lease.task);
  }

  void Forget(size_t worker, const Lease& lease, Fate fate) {
    if (fate == Fate::kFail) {
      EXPECT_FALSE(scheduler_.Fail(lease, true, now_));
    } else {
      (void)scheduler_.Release(lease, now_);
    }
    Remember(lease.task);
    std::erase(held_[worker], Lease(lease));  // a copy: `lease` may lie in there
  }

  void ExpireAll() {
    EXPECT_TRUE(scheduler_.Expire(now_).empty());
    for (auto& [task, truth] : truth_) {
      Remember(task);
    }
  }

  // The server dies and comes back with what the catalog kept.
  void Restart() {
    scheduler_ = Scheduler(kOptions);
    for (const auto& [task, truth] : truth_) {
      if (truth.accepted > 0) {
        continue;
      }
      if (truth.leased) {
        scheduler_.RestoreLease(task, truth.attempts, truth.worker, now_);
      } else {
        scheduler_.AddTask(task, truth.attempts);
      }
    }
  }

  void Remember(const TaskId& task) {
    TaskTruth& truth = truth_.at(task);
    if (truth.accepted > 0) {
      truth.leased = false;
      return;
    }
    truth.attempts = scheduler_.AttemptsOf(task);
    truth.leased = scheduler_.LeaseOf(task).has_value();
  }

  void CheckCounts() {
    int64_t open = 0;
    int64_t leased = 0;
    for (const auto& [task, truth] : truth_) {
      open += truth.accepted == 0 ? 1 : 0;
      leased += truth.leased ? 1 : 0;
    }
    ASSERT_EQ(scheduler_.LeasedCount(), leased);
    ASSERT_EQ(scheduler_.ReadyCount(), open - leased);
  }

  [[nodiscard]] bool AllDone() const {
    return std::all_of(truth_.begin(), truth_.end(),
                       [](const auto& item) { return item.second.accepted > 0; });
  }

  Random random_;
  MonotonicTime now_{};
  Scheduler scheduler_;
  std::map<TaskId, TaskTruth> truth_;
  std::vector<std::vector<Lease>> held_;  // What each worker believes to hold.
  std::vector<Lease> past_;               // Every lease ever granted.
  std::set<std::pair<TaskId, int64_t>> granted_;
};

TEST(SchedulerSimulation, EveryTaskIsAcceptedExactlyOnceInFiveHundredStorms) {
  for (uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Storm storm(seed);
    storm.Rage();
    storm.Calm();
    storm.CheckEnd();
    if (HasFailure()) {
      break;
    }
  }
}

struct Ends {
  int64_t done = 0;
  int64_t given_up = 0;
};

// A worker takes up to two tasks and completes, fails or forgets each.
void WorkASecond(MonotonicTime now, Random& random, Scheduler& scheduler, Ends& ends) {
  for (const Lease& lease : scheduler.Grant({"w"}, 2, now)) {
    const int64_t fate = random.Below(4);
    if (fate == 0) {
      ends.done += scheduler.Complete(lease) == CompletionVerdict::kAccepted ? 1 : 0;
    } else if (fate == 1) {
      ends.given_up += scheduler.Fail(lease, true, now) ? 1 : 0;
    }  // Otherwise the worker falls silent.
  }
  ends.given_up += static_cast<int64_t>(scheduler.Expire(now).size());
}

// Tasks that fail for good end as given up, never as lost: each is done or given up, once.
TEST(SchedulerSimulation, EveryTaskEndsDoneOrGivenUp) {
  for (uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Scheduler scheduler(
        {.lease_seconds = 10, .max_failures = 3, .max_losses = 3, .retry_seconds = 1});
    const int64_t tasks = 1 + random.Below(30);
    for (int64_t number = 0; number < tasks; ++number) {
      scheduler.AddTask({{"j"}, number});
    }
    Ends ends;
    MonotonicTime now{};
    for (int step = 0; step < 2000 && ends.done + ends.given_up < tasks; ++step) {
      now += std::chrono::seconds(1);
      WorkASecond(now, random, scheduler, ends);
    }
    ASSERT_EQ(ends.done + ends.given_up, tasks);
    ASSERT_EQ(scheduler.ReadyCount() + scheduler.LeasedCount(), 0);
  }
}

}  // namespace
}  // namespace cohort
