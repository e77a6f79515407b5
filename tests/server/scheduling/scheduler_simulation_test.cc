// A deterministic simulator: a server with its catalog, workers and a network on a bad day, drawn
// from a seed. A failure names its seed; COHORT_SIM_FIRST_SEED and COHORT_SIM_SEEDS choose others:
//   COHORT_SIM_FIRST_SEED=1234 COHORT_SIM_SEEDS=1 server_scheduling_test --gtest_filter='*Storm*'
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "server/scheduling/scheduler.h"

namespace cohort {
namespace {

constexpr int kJobs = 4;
constexpr size_t kWorkers = 5;
constexpr int kStormSteps = 400;

int64_t FromEnvironment(const char* name, int64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoll(text);
}

// What the catalog keeps of a task, and what the simulator knows besides.
struct TaskTruth {
  TaskAttempts stored;     // Written with each grant, failure and release.
  WorkerId stored_worker;  // Empty: not out.
  int failures = 0;        // Reported on current leases.
  int accepted = 0;
  bool given_up = false;
  bool is_removed = false;  // With its job.
};

// Every step does one random thing; after the storm one healthy worker must be able to finish what
// was not given up.
class Storm {
 public:
  explicit Storm(uint64_t seed) : random_(seed), options_(DrawOptions()), scheduler_(options_) {
    for (int job = 0; job < kJobs; ++job) {
      priorities_.push_back(static_cast<int>(random_.Below(2)));
      paused_.push_back(false);
      SetJob(job);
      const int64_t count = 1 + random_.Below(20);
      scheduler_.AddTasks(JobOf(job), 1, count);
      for (int64_t number = 1; number <= count; ++number) {
        truth_[{JobOf(job), number}];
      }
    }
  }

  void Rage() {
    for (int step = 0; step < kStormSteps && !::testing::Test::HasFailure(); ++step) {
      // Sometimes the machine sleeps: everything has run out at once.
      now_ += random_.Below(200) == 0 ? std::chrono::milliseconds(3'600'000)
                                      : std::chrono::milliseconds(random_.Below(500));
      DoOneThing(static_cast<size_t>(random_.Below(kWorkers)));
      if (step % 8 == 0) {
        CheckCounts();
      }
    }
  }

  // One worker that always renews; the others are gone.
  void Calm() {
    for (std::vector<HeldTask>& held : held_) {
      held.clear();
    }
    for (int job = 0; job < kJobs; ++job) {
      paused_[static_cast<size_t>(job)] = false;
      SetJob(job);
    }
    for (int step = 0; step < 20000 && !AllEnded(); ++step) {
      now_ += std::chrono::seconds(1);
      ExpireAll();
      GrantTo(0);
      RenewFor(0);
      if (!held_[0].empty()) {
        const Lease lease = held_[0].front().lease;
        held_[0].erase(held_[0].begin());
        CompleteLease(lease);
      }
    }
  }

  void CheckEnd() {
    for (const auto& [task, truth] : truth_) {
      const int expected = truth.given_up || truth.is_removed ? 0 : 1;
      EXPECT_GE(truth.accepted, expected) << task.job.value << " task " << task.number;
      EXPECT_LE(truth.accepted, 1) << task.job.value << " task " << task.number;
    }
    EXPECT_EQ(scheduler_.ReadyCount(), 0);
    EXPECT_EQ(scheduler_.LeasedCount(), 0);
  }

 private:
  enum class Fate { kFail, kFailForGood, kRelease };
  static JobId JobOf(int job) { return {absl::StrCat("j-", job)}; }
  static WorkerId WorkerOf(size_t worker) { return {absl::StrCat("w-", worker)}; }

  SchedulerOptions DrawOptions() {
    const bool patient = random_.Below(2) == 0;  // Then every task must end well.
    return {.lease_seconds = 10,
            .max_failures = patient ? 100000 : 3,
            .max_losses = patient ? 100000 : 3,
            .retry_seconds = 0.5,
            .stall_seconds = 40,
            .evict_seconds = 20,
            .unheard_seconds = 5,
            .copy_factor = 2,
            .least_copy_seconds = 1};
  }

  void SetJob(int job) {
    scheduler_.SetJob(JobOf(job),
                      {.priority = priorities_[static_cast<size_t>(job)],
                       .is_paused = paused_[static_cast<size_t>(job)],
                       .traits_of = [](int64_t number) {
                         return TaskTraits{.stage = 0, .reads = {number / 4, number % 4}};
                       }});
  }

  void DoOneThing(size_t worker) {
    switch (random_.Below(16)) {
      case 0:
      case 1:
      case 2:
        return GrantTo(worker);
      case 3:
      case 4:
      case 5:
        return RenewFor(worker);
      case 6:
      case 7:
        return FinishAny(worker);
      case 8:
        return ForgetAny(worker, Fate::kFail);
      case 9:
        return ForgetAny(worker, random_.Below(8) == 0 ? Fate::kFailForGood : Fate::kFail);
      case 10:
        return ForgetAny(worker, Fate::kRelease);
      case 11:
        if (random_.Below(6) == 0) {
          held_[worker].clear();  // It crashed.
        }
        return;
      case 12:
        return ExpireAll();
      case 13:
        if (!past_.empty()) {  // Late, or twice.
          CompleteLease(past_[static_cast<size_t>(random_.Below(std::ssize(past_)))]);
        }
        return;
      case 14:
        if (random_.Below(20) == 0) {
          Restart();
        }
        return;
      default:
        return DoSomethingToAJob(static_cast<int>(random_.Below(kJobs)));
    }
  }

  void DoSomethingToAJob(int job) {
    const int64_t what = random_.Below(60);
    if (what == 0) {
      scheduler_.RemoveJob(JobOf(job));
      SetJob(job);
      for (auto& [task, truth] : truth_) {
        truth.is_removed |= task.job == JobOf(job);
      }
    } else if (what < 20) {
      paused_[static_cast<size_t>(job)] = !paused_[static_cast<size_t>(job)];
      SetJob(job);
    }
  }

  void GrantTo(size_t worker) {
    // A wedged worker reports no progress, a slow one some.
    for (const Lease& lease :
         scheduler_.Grant(WorkerOf(worker), static_cast<int>(1 + random_.Below(3)), now_)) {
      EXPECT_TRUE(granted_.emplace(lease.task, lease.epoch).second) << "the same lease twice";
      TaskTruth& truth = truth_.at(lease.task);
      EXPECT_EQ(truth.accepted, 0) << "granted after it was done";
      EXPECT_FALSE(truth.given_up || truth.is_removed);
      EXPECT_FALSE(paused_.at(static_cast<size_t>(lease.task.job.value.back() - '0')));
      EXPECT_GT(lease.epoch, truth.stored.epoch);
      EXPECT_LE(CurrentCopies(lease.task), 2) << "a third copy";
      if (random_.Below(25) == 0) {
        EXPECT_TRUE(scheduler_.Release(lease, now_));  // The catalog could not write it.
        truth.stored.epoch = lease.epoch;              // As the next grant would have it.
        continue;
      }
      truth.stored = scheduler_.AttemptsOf(lease.task);
      truth.stored_worker = WorkerOf(worker);
      if (random_.Below(15) == 0) {
        unheard_[worker].emplace(lease, now_);  // The answer is lost.
      } else {
        held_[worker].push_back({.lease = lease});
      }
      past_.push_back(lease);
      past_worker_.emplace(lease, worker);
    }
  }

  [[nodiscard]] int CurrentCopies(const TaskId& task) const {
    int copies = 0;
    for (const auto& [granted, epoch] : granted_) {
      copies += granted == task && scheduler_.IsCurrent({task, epoch}) ? 1 : 0;
    }
    return copies;
  }

  void RenewFor(size_t worker) {
    for (HeldTask& task : held_[worker]) {
      if (random_.Below(3) != 0) {
        ++task.ticks;
      }
    }
    const Renewal renewal = scheduler_.Renew(WorkerOf(worker), held_[worker], now_);
    NoteGivenUp(renewal.given_up);
    for (const Lease& lost : renewal.lost) {
      EXPECT_FALSE(scheduler_.IsCurrent(lost)) << "a current lease";
    }
    const bool is_deaf = random_.Below(10) == 0;  // It goes on with what it was told to stop.
    if (renewal.is_wedged) {
      EXPECT_FALSE(renewal.lost.empty());
      held_[worker].clear();  // It ends.
    } else if (!is_deaf) {
      std::erase_if(held_[worker], [&](const HeldTask& task) {
        return std::count(renewal.lost.begin(), renewal.lost.end(), task.lease) > 0;
      });
    }
    for (const HeldTask& task : held_[worker]) {
      EXPECT_TRUE(is_deaf || scheduler_.IsCurrent(task.lease)) << "nobody told the worker";
    }
    TakeBackUnheardOf(worker);
  }

  void TakeBackUnheardOf(size_t worker) {
    // What its last report held, and what was granted since, stays.
    const std::vector<Lease> taken = scheduler_.TakeBackUnheard(WorkerOf(worker), now_);
    for (const Lease& lease : taken) {
      EXPECT_FALSE(scheduler_.IsCurrent(lease));
      for (const HeldTask& task : held_[worker]) {
        EXPECT_NE(task.lease, lease) << "taken from a worker that has it";
      }
    }
    for (const auto& [lease, granted] : std::exchange(unheard_[worker], {})) {
      if (now_ - granted < std::chrono::seconds(5)) {
        unheard_[worker].emplace(lease, granted);
      } else {
        EXPECT_FALSE(scheduler_.IsCurrent(lease)) << "still waits for a worker that has no idea";
      }
    }
  }

  void FinishAny(size_t worker) {
    if (!held_[worker].empty()) {
      const auto place = random_.Below(std::ssize(held_[worker]));
      const Lease lease = held_[worker][static_cast<size_t>(place)].lease;
      held_[worker].erase(held_[worker].begin() + place);
      CompleteLease(lease);
    }
  }

  void CompleteLease(const Lease& lease) {
    TaskTruth& truth = truth_.at(lease.task);
    const CompletionVerdict verdict = scheduler_.Complete(lease, now_);
    if (truth.accepted == 0 && !truth.given_up && !truth.is_removed) {
      EXPECT_EQ(verdict, CompletionVerdict::kAccepted);
      ++truth.accepted;
      EXPECT_EQ(CurrentCopies(lease.task), 0) << "a copy of what is done";
    } else {
      EXPECT_NE(verdict, CompletionVerdict::kAccepted);
    }
  }

  void ForgetAny(size_t worker, Fate fate) {
    if (held_[worker].empty()) {
      return;
    }
    const auto place = random_.Below(std::ssize(held_[worker]));
    const Lease lease = held_[worker][static_cast<size_t>(place)].lease;
    held_[worker].erase(held_[worker].begin() + place);
    TaskTruth& truth = truth_.at(lease.task);
    if (!scheduler_.IsCurrent(lease)) {
      EXPECT_FALSE(scheduler_.Fail(lease, false, now_)) << "a stale lease did something";
      return;
    }
    if (fate == Fate::kRelease) {
      EXPECT_TRUE(scheduler_.Release(lease, now_));
    } else {
      ++truth.failures;
      const bool for_good = fate == Fate::kFailForGood && options_.max_failures < 100;
      truth.given_up = scheduler_.Fail(lease, !for_good, now_);
      EXPECT_EQ(truth.given_up, for_good || truth.failures >= options_.max_failures);
    }
    truth.stored = scheduler_.AttemptsOf(lease.task);
    EXPECT_EQ(truth.stored.failures, truth.failures) << "a loss counted as a failure";
    const std::optional<Lease> left = scheduler_.LeaseOf(lease.task);
    truth.stored_worker = left ? WorkerOf(past_worker_.at(*left)) : WorkerId();
  }

  void ExpireAll() { NoteGivenUp(scheduler_.Expire(now_)); }

  void NoteGivenUp(const std::vector<TaskId>& tasks) {
    for (const TaskId& task : tasks) {
      EXPECT_GE(scheduler_.AttemptsOf(task).losses, options_.max_losses);
      truth_.at(task).given_up = true;
    }
  }

  // The server dies and comes back with what the catalog kept.
  void Restart() {
    scheduler_ = Scheduler(options_);
    for (int job = 0; job < kJobs; ++job) {
      SetJob(job);
    }
    for (const auto& [task, truth] : truth_) {
      if (truth.accepted > 0 || truth.given_up || truth.is_removed) {
        continue;
      }
      if (truth.stored_worker.value.empty()) {
        scheduler_.AddTask(task, truth.stored);
      } else {
        scheduler_.RestoreLease(task, truth.stored, truth.stored_worker, now_);
      }
    }
    for (auto& unheard : unheard_) {
      for (auto& [lease, granted] : unheard) {
        granted = now_;
      }
    }
    // A late result of what was done before the restart finds a scheduler that never heard of it.
    std::erase_if(past_, [&](const Lease& lease) { return truth_.at(lease.task).accepted > 0; });
  }

  void CheckCounts() {
    int64_t open = 0;
    for (const auto& [task, truth] : truth_) {
      open += truth.accepted == 0 && !truth.given_up && !truth.is_removed ? 1 : 0;
    }
    EXPECT_EQ(scheduler_.LeasedCount() + scheduler_.ReadyCount(), open);
    int64_t open_by_job = 0;
    for (int job = 0; job < kJobs; ++job) {
      open_by_job += scheduler_.OpenCount(JobOf(job));
    }
    EXPECT_EQ(open_by_job, open);
  }

  [[nodiscard]] bool AllEnded() const {
    return std::all_of(truth_.begin(), truth_.end(), [](const auto& item) {
      return item.second.accepted > 0 || item.second.given_up || item.second.is_removed;
    });
  }

  Random random_;
  MonotonicTime now_{};
  SchedulerOptions options_;
  Scheduler scheduler_;
  std::vector<int> priorities_;
  std::vector<bool> paused_;
  std::map<TaskId, TaskTruth> truth_;
  std::vector<std::vector<HeldTask>> held_{kWorkers};  // What each worker believes to hold.
  // What each was granted in an answer that was lost, and when, or when the server last restarted.
  std::vector<std::map<Lease, MonotonicTime>> unheard_{kWorkers};
  std::vector<Lease> past_;  // Every lease ever handed out.
  std::map<Lease, size_t> past_worker_;
  std::set<std::pair<TaskId, int64_t>> granted_;
};

TEST(SchedulerSimulation, EveryTaskEndsOnceInThousandsOfStorms) {
  const int64_t first = FromEnvironment("COHORT_SIM_FIRST_SEED", 0);
  const int64_t count = FromEnvironment("COHORT_SIM_SEEDS", 3000);
  for (int64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE(absl::StrCat("COHORT_SIM_FIRST_SEED=", seed));
    Storm storm(static_cast<uint64_t>(seed));
    storm.Rage();
    storm.Calm();
    storm.CheckEnd();
    if (HasFailure()) {
      break;
    }
  }
}

// Slots that are always full, tasks of random length: what each task of a job waited for, from when
// the job was added.
class Cluster {
 public:
  Cluster(uint64_t seed, int slots)
      : random_(seed), scheduler_({.lease_seconds = 1e9}), slots_(static_cast<size_t>(slots)) {}

  void Add(const std::string& job, int64_t tasks, int priority) {
    scheduler_.SetJob({job}, {.priority = priority, .is_paused = false, .traits_of = nullptr});
    scheduler_.AddTasks({job}, 0, tasks);
  }

  // Runs until `job` has ended; the seconds that took.
  double RunUntilEnded(const std::string& job) {
    const MonotonicTime start = now_;
    while (scheduler_.OpenCount({job}) > 0) {
      for (size_t slot = 0; slot < slots_.size(); ++slot) {
        Fill(slot);
      }
      auto next = std::min_element(slots_.begin(), slots_.end(), [](const Slot& a, const Slot& b) {
        return std::pair(!a.lease, a.until) < std::pair(!b.lease, b.until);
      });
      now_ = next->until;
      EXPECT_EQ(scheduler_.Complete(*next->lease, now_), CompletionVerdict::kAccepted);
      next->lease.reset();
    }
    return std::chrono::duration<double>(now_ - start).count();
  }

 private:
  struct Slot {
    std::optional<Lease> lease;
    MonotonicTime until{};
  };
  void Fill(size_t slot) {
    if (slots_[slot].lease) {
      return;
    }
    const auto granted = scheduler_.Grant({absl::StrCat("w", slot)}, 1, now_);
    if (!granted.empty()) {
      slots_[slot].lease = granted[0];
      slots_[slot].until = now_ + std::chrono::milliseconds(500 + random_.Below(500));
    }
  }

  Random random_;
  MonotonicTime now_{};
  Scheduler scheduler_;
  std::vector<Slot> slots_;
};

// Promise P11.
TEST(SchedulerSimulation, ASmallJobIsNotHeldUpByAHugeOne) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Cluster cluster(seed, 8);
    cluster.Add("huge", 100'000, 0);
    cluster.Add("warm-up", 8, 0);
    (void)cluster.RunUntilEnded("warm-up");
    cluster.Add("small", 10, 0);
    // A second at most until four of the eight slots are its own, three rounds of a second each.
    EXPECT_LT(cluster.RunUntilEnded("small"), 5) << "seed " << seed;
  }
}

TEST(SchedulerSimulation, AJobOfHigherPriorityGetsEverySlotThatFallsFree) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Cluster cluster(seed, 8);
    cluster.Add("huge", 100'000, 0);
    cluster.Add("warm-up", 8, 0);
    (void)cluster.RunUntilEnded("warm-up");
    cluster.Add("urgent", 32, 1);
    EXPECT_LT(cluster.RunUntilEnded("urgent"), 1 + 32.0 / 8 + 1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace cohort
