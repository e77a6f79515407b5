#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/jobs/ids.h"
#include "common/jobs/lease.h"
#include "common/jobs/task.h"
#include "server/scheduling/duration_histogram.h"
#include "server/scheduling/number_set.h"

namespace cohort {

struct SchedulerOptions {
  double lease_seconds = 60;   ///< A worker that is silent for this long loses its tasks.
  int max_failures = 3;        ///< Failures of one task before it is given up.
  int max_losses = 5;          ///< Workers lost with one begun task before it is given up.
  double retry_seconds = 1;    ///< Wait before the first retry of a failed task; doubles.
  double stall_seconds = 900;  ///< A task that does not get on for this long is taken back.
  double evict_seconds = 60;   ///< A worker that goes on with a task taken back is to end after it.
  double unheard_seconds = 5;  ///< A worker that has not listed a grant by then never heard of it.
  double copy_factor = 2;      ///< A second copy runs of a task slower than this times the 95th
                               ///< percentile of its stage, when nothing else is left to do,
  double least_copy_seconds = 5;  ///< and slower than this.
};

/// Where a task stands; kept by the catalog too.
struct TaskAttempts {
  int64_t epoch = 0;
  int failures = 0;  ///< The task itself failed.
  int losses = 0;    ///< Its worker was lost while it ran; not the task's fault.
};

/// How a job is served.
struct JobOptions {
  int priority = 0;  ///< Jobs of a higher priority come first, always.
  bool is_paused = false;
  std::function<TaskTraits(int64_t number)> traits_of;  ///< Null: all alike.
};

enum class CompletionVerdict {
  kAccepted,   ///< First result of the task (also from an expired lease: the task is pure).
  kDuplicate,  ///< The task is done already.
  kNotActive,  ///< Unknown, cancelled or given up.
};

/// A lease that was taken back.
struct LostLease {
  Lease lease;
  WorkerId worker;
};

/// What a worker is told about the leases that it reported.
struct Renewal {
  std::vector<Lease> lost;       ///< Expired, taken back, cancelled, done: the worker stops them.
  bool is_wedged = false;        ///< It goes on with such a lease all the same: it is to end.
  std::vector<TaskId> given_up;  ///< Tasks that did not get on too often (max_losses).
};

/// Who does what, until when. Time is an argument; nothing blocks. Every call costs O(log n) for
/// each task that it touches; tasks that nothing has happened to cost no memory. Not thread-safe.
///
/// Among jobs of the highest priority that have a ready task, the one with the fewest tasks out
/// comes first, so that a small job never waits for a large one. Of its first tasks in number order
/// that cost about as much the worker gets one that reads what it has read before.
class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options) : options_(options) {}

  /// Sets how a job is served; it need not be there yet.
  void SetJob(const JobId& job, JobOptions options);
  /// Adds ready tasks, new ones all.
  void AddTasks(const JobId& job, int64_t first, int64_t count);
  /// Adds a ready task. `attempts` is what the catalog remembers of it. A task that is there
  /// already stays as it is.
  void AddTask(const TaskId& task, const TaskAttempts& attempts = {});
  /// Restores a lease after a restart: `worker` has one lease time to report in. A task that is
  /// there already stays as it is.
  void RestoreLease(const TaskId& task,
                    const TaskAttempts& attempts,
                    const WorkerId& worker,
                    MonotonicTime now);

  /// Grants up to `count` tasks. When none is ready, second copies of tasks that take too long.
  [[nodiscard]] std::vector<Lease> Grant(const WorkerId& worker, int count, MonotonicTime now);
  /// Extends the leases that `worker` says it holds.
  [[nodiscard]] Renewal Renew(const WorkerId& worker,
                              const std::vector<HeldTask>& held,
                              MonotonicTime now);
  /// Takes back what `worker` was granted and has never listed, of grants older than
  /// `unheard_seconds` when its last report arrived: the answer with the grant was lost. Neither a
  /// failure nor a loss. To be called after Renew.
  /// @param reported  when that report arrived; it may have waited since.
  std::vector<Lease> TakeBackUnheard(const WorkerId& worker, MonotonicTime reported);
  /// A result has come; ends the task, and its other copy.
  CompletionVerdict Complete(const Lease& lease, MonotonicTime now);
  /// The worker gives the task back unfinished (drain). Not a failure. False if the lease is stale.
  bool Release(const Lease& lease, MonotonicTime now);
  /// The task failed on this worker.
  /// @param retryable  false: giving up at once.
  /// @return true if the task is given up: its job cannot finish it. False: it will be retried, its
  ///         other copy goes on, or the lease is stale.
  bool Fail(const Lease& lease, bool retryable, MonotonicTime now);
  /// Takes back leases that ran out; returns the tasks that are given up thereby (max_losses).
  std::vector<TaskId> Expire(MonotonicTime now);
  /// Forgets all tasks of a job.
  void RemoveJob(const JobId& job);

  /// Of a job that is not paused.
  [[nodiscard]] bool HasReadyTask(MonotonicTime now) const;
  /// Of a task that is done or unknown: none.
  [[nodiscard]] TaskAttempts AttemptsOf(const TaskId& task) const;
  /// The task's newest lease, if it is out.
  [[nodiscard]] std::optional<Lease> LeaseOf(const TaskId& task) const;
  /// When this lease was granted; nothing if it is not out.
  [[nodiscard]] std::optional<MonotonicTime> GrantedAt(const Lease& lease) const;
  /// True if the task is ready, waits or is out.
  [[nodiscard]] bool IsOpen(const TaskId& task) const;
  /// Who has this lease; nobody if it is not out.
  [[nodiscard]] std::optional<WorkerId> HolderOf(const Lease& lease) const;
  /// True if this very lease is out.
  [[nodiscard]] bool IsCurrent(const Lease& lease) const { return GrantedAt(lease).has_value(); }
  /// Tasks that wait for a worker or for the end of their back-off.
  [[nodiscard]] int64_t ReadyCount() const;
  /// Those that Grant could hand out now: not of paused jobs, not in their back-off.
  [[nodiscard]] int64_t GrantableCount() const;
  [[nodiscard]] int64_t LeasedCount() const { return leased_count_; }
  /// Leases taken back since the last call because their workers were silent or did not get on.
  [[nodiscard]] std::vector<LostLease> TakeLost() { return std::exchange(lost_, {}); }
  /// Second copies handed out of tasks that took too long, since the start.
  [[nodiscard]] int64_t SecondCopyCount() const { return second_copy_count_; }
  /// Tasks of the job that are ready, wait or are out: 0 if all are done or given up.
  [[nodiscard]] int64_t OpenCount(const JobId& job) const;

 private:
  /// One copy of a task that is out.
  struct Copy {
    WorkerId worker;
    int64_t epoch = 0;
    MonotonicTime granted{};
    MonotonicTime until{};         ///< Expires then.
    std::optional<int64_t> ticks;  ///< As last reported.
    MonotonicTime got_on{};        ///< When they last changed.
  };
  /// A task that something has happened to and that is not done.
  struct Entry {
    enum class State { kReady, kWaiting, kLeased, kGivenUp } state = State::kReady;
    TaskAttempts attempts;
    MonotonicTime until{};     ///< kWaiting: ready then.
    std::vector<Copy> copies;  ///< kLeased: one or two.
  };
  struct JobTasks {
    JobOptions options;
    std::map<int64_t, Entry> entries;
    NumberSet ready;  ///< Also of those without an entry.
    NumberSet done;
    int64_t waiting = 0;
    int64_t leased = 0;
    std::map<int64_t, DurationHistogram> durations;  ///< By stage.
  };
  /// What a worker has read lately, newest last.
  using Memory = std::deque<std::pair<JobId, int64_t>>;

  [[nodiscard]] bool IsKnown(const TaskId& task) const;
  [[nodiscard]] Entry* Find(const TaskId& task);
  [[nodiscard]] const Entry* Find(const TaskId& task) const;
  /// The copy that a lease stands for; null if it is stale.
  [[nodiscard]] Copy* FindCopy(const Lease& lease);
  [[nodiscard]] const Copy* FindCopy(const Lease& lease) const;
  /// The only place that changes a state: keeps the counts and indexes true. A task that becomes
  /// ready without attempts needs no entry.
  void MoveTo(const TaskId& task, Entry::State state, MonotonicTime until = {});
  void AddCopy(const TaskId& task, Copy copy);
  /// Takes a copy out of every index of copies.
  void RemoveFromIndexes(const TaskId& task, const Copy& copy);
  /// The worker has listed the lease, or it is over.
  void NoteHeard(const WorkerId& worker, const Lease& lease);
  /// The last copy gone leaves the task in `then`.
  void DropCopy(const Lease& lease, Entry::State then, MonotonicTime until = {});
  /// Its worker was lost with it. True: given up.
  bool Lose(const Lease& lease);
  [[nodiscard]] Lease GrantTo(const WorkerId& worker, const TaskId& task, MonotonicTime now);
  /// A task that is out, worth a second copy by `worker`.
  [[nodiscard]] std::optional<TaskId> FindSlowTask(const WorkerId& worker, MonotonicTime now) const;
  [[nodiscard]] bool IsSlow(const TaskId& task, const Copy& copy, MonotonicTime now) const;
  [[nodiscard]] TaskTraits TraitsOf(const TaskId& task) const;
  [[nodiscard]] int64_t PickTask(const JobId& job, const WorkerId& worker) const;
  void Remember(const WorkerId& worker, const TaskId& task);
  /// Makes tasks ready whose back-off is over.
  void WakeWaiting(MonotonicTime now);
  /// The next job to be served; see above.
  [[nodiscard]] std::optional<JobId> NextJob() const;
  [[nodiscard]] MonotonicTime LeaseEnd(MonotonicTime now) const;

  SchedulerOptions options_;
  std::map<JobId, JobTasks> jobs_;
  std::set<JobId> jobs_with_ready_;
  std::set<std::pair<MonotonicTime, TaskId>> waiting_;
  std::set<std::tuple<MonotonicTime, TaskId, int64_t>> expiries_;  ///< Of copies, with the epoch.
  std::set<std::pair<MonotonicTime, TaskId>> single_copies_;       ///< Tasks out once, by grant.
  std::map<WorkerId, std::map<Lease, MonotonicTime>> unheard_;     ///< Never listed; by grant.
  std::map<WorkerId, Memory> memories_;
  std::map<WorkerId, std::map<Lease, MonotonicTime>> told_;  ///< Since when to stop a lease.
  int64_t ready_count_ = 0;                                  ///< Not waiting.
  int64_t leased_count_ = 0;
  std::vector<LostLease> lost_;  ///< Not told yet.
  int64_t second_copy_count_ = 0;
  JobId last_served_;  ///< Equal jobs take turns after this one.
};

}  // namespace cohort
