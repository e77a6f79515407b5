#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <absl/status/status.h>

#include "common/base/mutex.h"
#include "common/jobs/worker_protocol.h"
#include "worker/coordinator_link.h"
#include "worker/tasks/task_runner.h"

namespace cohort {

struct WorkerLoopOptions {
  WorkerId worker;
  std::string build;
  int slots = 1;        ///< Tasks computed at once: what the runner allows.
  int spare_slots = 1;  ///< Tasks held besides: begun, or reported, while those compute.
  std::string instruction_set;
  double drain_seconds = 10;  ///< How long running tasks may go on after the stop.
};

/// What a worker has done since it started, and does now.
struct WorkerFigures {
  int slots = 0;
  int64_t held = 0;       ///< Tasks; those that wait for a slot included.
  int64_t computing = 0;  ///< Tasks that have a slot.
  int64_t completed = 0;
  int64_t failed = 0;
  int64_t released = 0;  ///< Given back, or told to stop.
  double seconds = 0;    ///< What those completed took.
};

/// Asks for tasks, runs each on a thread of its own, reports what came out. While tasks run it
/// keeps calling the server, so that their leases live. Holds a task more than it can compute, so
/// that no processor waits while a result is on its way. A result that is sent while no other call
/// is under way takes the next report with it and brings the next task back; while there is enough
/// to compute, and writing does not take long, nothing else asks for one.
class WorkerLoop {
 public:
  WorkerLoop(const WorkerLoopOptions& options, CoordinatorLink& link, TaskRunner& runner);
  ~WorkerLoop();
  WorkerLoop(const WorkerLoop&) = delete;
  WorkerLoop& operator=(const WorkerLoop&) = delete;

  /// Works until `stop`, then drains: no new tasks; those under way get drain_seconds, what is not
  /// done by then is given back.
  /// @return kFailedPrecondition if the server refuses this build; kAborted if a task goes on after
  ///         the server has told it to stop: only the end of the process helps, without waiting for
  ///         this object's.
  [[nodiscard]] absl::Status Run(const std::stop_token& stop);

  /// May be called from any thread.
  [[nodiscard]] WorkerFigures Figures();

 private:
  struct Running {
    std::stop_source stop;
    std::shared_ptr<std::atomic<int64_t>> ticks =
        std::make_shared<std::atomic<int64_t>>(HeldTask::kNotBegun);
    std::thread thread;
    bool computed = false;  ///< Only writes and reports now.
    bool is_told = false;   ///< The server's last orders take its end into account.
    bool finished = false;
  };

  /// What it holds and could take. `over`: a task that will have ended when this is read.
  [[nodiscard]] WorkerReport MakeReport(const Lease* over) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status SynchronizeOnce();
  void StopTakingTasks() ABSL_LOCKS_EXCLUDED(mutex_);
  /// Does what the server answered. Also what it said to another report than the last one: nobody
  /// else hears of a grant, and a lease once lost stays lost.
  /// @return the tasks that it no longer takes, for the caller to release
  [[nodiscard]] std::vector<Lease> Follow(const WorkerOrders& orders) ABSL_LOCKS_EXCLUDED(mutex_);
  void Release(const std::vector<Lease>& leases);
  void Start(const GrantedTask& granted) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RunSlot(const GrantedTask& granted,
               const std::stop_token& stop,
               std::atomic<int64_t>& ticks);
  void Report(const Lease& lease, absl::StatusOr<TaskResult> result, const std::stop_token& stop);
  /// Says the result, and hears what is next if no other call asks for that.
  absl::Status Complete(const Lease& lease, const TaskResult& result);
  /// The task has given its slot back: asks for another, now or soon, if none waits for the slot.
  void NoteComputed(const Lease& lease) ABSL_LOCKS_EXCLUDED(mutex_);
  /// The server has heard of the task's end.
  void NoteEnded(const Lease& lease, const absl::StatusOr<TaskResult>& result);
  /// The loop has reason to call the server: the time has come, or there is news and nobody has
  /// just asked.
  [[nodiscard]] bool IsCallDue() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Joins threads whose task is over.
  void Reap() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Drain();

  const WorkerLoopOptions options_;
  CoordinatorLink& link_;
  TaskRunner& runner_;
  Mutex mutex_;
  CondVar slot_freed_;
  std::map<Lease, Running> running_ ABSL_GUARDED_BY(mutex_);
  WorkerFigures figures_ ABSL_GUARDED_BY(mutex_);  ///< Its totals.
  /// A task has ended, or a slot has nothing to compute, since the last report.
  bool has_news_ ABSL_GUARDED_BY(mutex_) = false;
  bool takes_tasks_ ABSL_GUARDED_BY(mutex_) = false;      ///< Run is neither stopped nor over.
  bool is_asking_ ABSL_GUARDED_BY(mutex_) = false;        ///< A report has not been answered yet.
  bool is_out_of_reach_ ABSL_GUARDED_BY(mutex_) = false;  ///< The last Synchronize failed.
  std::chrono::steady_clock::time_point next_sync_ ABSL_GUARDED_BY(mutex_);
  std::atomic<double> lease_seconds_ = 60;  ///< As the server last said.
};

}  // namespace cohort
