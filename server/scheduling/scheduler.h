#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/jobs/ids.h"
#include "common/jobs/lease.h"

namespace cohort {

struct SchedulerOptions {
  double lease_seconds = 60;  ///< A worker that is silent for this long loses its tasks.
  int max_failures = 3;       ///< Failures of one task before it is given up.
  int max_losses = 20;        ///< Workers lost with one task before it is given up.
  double retry_seconds = 1;   ///< Wait before the first retry of a failed task; doubles.
};

/// Where a task stands; kept by the catalog too.
struct TaskAttempts {
  int64_t epoch = 0;
  int failures = 0;  ///< The task itself failed.
  int losses = 0;    ///< Its worker was lost; not the task's fault.
};

enum class CompletionVerdict {
  kAccepted,   ///< First result of the task (also from an expired lease: the task is pure).
  kDuplicate,  ///< The task is done already.
  kNotActive,  ///< Unknown, cancelled or given up.
};

/// Who does what, until when. Time is an argument; nothing blocks. Every call costs O(log n) for
/// each task that it touches. Not thread-safe.
class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options) : options_(options) {}

  /// Adds a ready task. `attempts` is what the catalog remembers of it. A task that is there
  /// already stays as it is.
  void AddTask(const TaskId& task, const TaskAttempts& attempts = {});
  /// Restores a lease after a restart: `worker` has one lease time to report in. A task that is
  /// there already stays as it is.
  void RestoreLease(const TaskId& task,
                    const TaskAttempts& attempts,
                    const WorkerId& worker,
                    MonotonicTime now);

  /// Grants up to `count` ready tasks: jobs take turns, tasks of a job in number order.
  [[nodiscard]] std::vector<Lease> Grant(const WorkerId& worker, int count, MonotonicTime now);
  /// Extends the leases that `worker` says it holds; returns those it holds no longer (expired and
  /// taken back, cancelled, done): the worker stops them.
  [[nodiscard]] std::vector<Lease> Renew(const WorkerId& worker,
                                         const std::vector<Lease>& held,
                                         MonotonicTime now);
  /// A result has come; ends the task.
  CompletionVerdict Complete(const Lease& lease);
  /// The worker gives the task back unfinished (drain). Not a failure. False if the lease is stale.
  bool Release(const Lease& lease, MonotonicTime now);
  /// The task failed on this worker.
  /// @param retryable  false: giving up at once.
  /// @return true if the task is given up: its job cannot finish it. False: it will be retried, or
  ///         the lease is stale.
  bool Fail(const Lease& lease, bool retryable, MonotonicTime now);
  /// Takes back leases that ran out; returns the tasks that are given up thereby (max_losses).
  std::vector<TaskId> Expire(MonotonicTime now);
  /// Forgets all tasks of a job.
  void RemoveJob(const JobId& job);

  [[nodiscard]] bool HasReadyTask(MonotonicTime now) const;
  [[nodiscard]] TaskAttempts AttemptsOf(const TaskId& task) const;
  /// Current lease of the task, if it is out.
  [[nodiscard]] std::optional<Lease> LeaseOf(const TaskId& task) const;
  /// Tasks that wait for a worker or for the end of their back-off.
  [[nodiscard]] int64_t ReadyCount() const;
  [[nodiscard]] int64_t LeasedCount() const;

 private:
  struct Entry {
    enum class State { kReady, kWaiting, kLeased, kDone, kGivenUp } state = State::kReady;
    TaskAttempts attempts;
    MonotonicTime until{};  ///< kWaiting: ready then; kLeased: expires then.
    WorkerId worker;        ///< kLeased.
  };
  struct JobTasks {
    std::map<int64_t, Entry> tasks;
    std::set<int64_t> ready;  ///< Numbers of the entries in kReady.
  };
  /// Tasks by the instant at which something happens to them, earliest first.
  using Agenda = std::set<std::pair<MonotonicTime, TaskId>>;

  [[nodiscard]] Entry* Find(const TaskId& task);
  [[nodiscard]] const Entry* Find(const TaskId& task) const;
  /// The entry of a current lease; null if it is stale.
  [[nodiscard]] Entry* FindLeased(const Lease& lease);
  /// The only place that changes a state: keeps the indexes below true.
  void MoveTo(const TaskId& task, Entry& entry, Entry::State state, MonotonicTime until = {});
  void Enter(const TaskId& task, const Entry& entry);
  void Leave(const TaskId& task, const Entry& entry);
  /// Makes tasks ready whose back-off is over.
  void WakeWaiting(MonotonicTime now);
  /// The next job in turn that has a ready task.
  [[nodiscard]] std::optional<JobId> NextJob() const;
  [[nodiscard]] MonotonicTime LeaseEnd(MonotonicTime now) const;

  SchedulerOptions options_;
  std::map<JobId, JobTasks> jobs_;
  std::set<JobId> jobs_with_ready_;
  Agenda waiting_;  ///< Entries in kWaiting.
  Agenda leased_;   ///< Entries in kLeased.
  int64_t ready_count_ = 0;
  JobId last_served_;  ///< Jobs take turns after this one.
};

}  // namespace cohort
