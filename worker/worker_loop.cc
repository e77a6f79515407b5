#include "worker/worker_loop.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "worker/retry_pause.h"

namespace cohort {
namespace {

using std::chrono::steady_clock;

constexpr double kIdleWaitSeconds = 10;
constexpr double kBusyWaitSeconds = 1;  ///< Leases under way must be renewed in time.
constexpr double kShortestPauseSeconds = 0.01;
/// A result that takes no longer than this to write brings the next task by itself.
constexpr double kPatienceSeconds = 0.02;

steady_clock::time_point In(double seconds) {
  return steady_clock::now() + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
}

/// The call may succeed later, as it is.
bool IsTransient(const absl::Status& status) {
  return status.code() == absl::StatusCode::kUnavailable ||
         status.code() == absl::StatusCode::kDeadlineExceeded ||
         status.code() == absl::StatusCode::kResourceExhausted;
}

}  // namespace

WorkerLoop::WorkerLoop(const WorkerLoopOptions& options, CoordinatorLink& link, TaskRunner& runner)
    : options_(options), link_(link), runner_(runner) {}

WorkerLoop::~WorkerLoop() {
  Drain();
}

absl::Status WorkerLoop::Run(const std::stop_token& stop) {
  {
    const MutexLock lock(mutex_);
    takes_tasks_ = true;
  }
  const std::stop_callback wake(stop, [this] {
    link_.CancelSynchronize();
    StopTakingTasks();
  });
  RetryPause retry;
  while (!stop.stop_requested()) {
    absl::Status status = SynchronizeOnce();
    if (stop.stop_requested()) {
      break;
    }
    if (status.code() == absl::StatusCode::kFailedPrecondition ||
        status.code() == absl::StatusCode::kAborted) {
      StopTakingTasks();
      return status;
    }
    MutexLock lock(mutex_);
    is_out_of_reach_ = !status.ok();
    if (status.ok()) {
      retry.Reset();
    } else {
      const double pause_seconds = retry.Next(lease_seconds_);
      next_sync_ = In(pause_seconds);
      spdlog::warn("event=sync_failed worker={} retry_seconds={} error=\"{}\"",
                   options_.worker.value, pause_seconds, std::string(status.message()));
    }
    Reap();
    while (!stop.stop_requested() && !IsCallDue()) {
      slot_freed_.WaitUntil(mutex_, next_sync_);
      Reap();
    }
  }
  return absl::OkStatus();
}

void WorkerLoop::StopTakingTasks() {
  const MutexLock lock(mutex_);
  takes_tasks_ = false;
  slot_freed_.NotifyAll();
}

bool WorkerLoop::IsCallDue() const {
  // The server says when to call again; sooner when there is news, if it can be reached.
  return steady_clock::now() >= next_sync_ || (has_news_ && !is_asking_ && !is_out_of_reach_);
}

WorkerReport WorkerLoop::MakeReport(const Lease* over) {
  WorkerReport report;
  report.worker = options_.worker;
  report.build = options_.build;
  report.slots = options_.slots;
  report.instruction_set = options_.instruction_set;
  int written = 0;
  Reap();
  has_news_ = false;
  is_asking_ = true;
  for (const auto& [lease, running] : running_) {
    if (over == nullptr || lease != *over) {
      report.held.push_back({.lease = lease, .ticks = *running.ticks});
      written += running.computed ? 1 : 0;
    }
  }
  // A task that is being written leaves its slot to another; not more of them than slots, so that
  // they do not heap up before a slow store.
  const int held = static_cast<int>(report.held.size()) - std::min(written, options_.slots);
  report.free_slots = std::max(0, options_.slots - held);
  report.spare_slots =
      std::max(0, options_.slots + options_.spare_slots - held - report.free_slots);
  report.wait_seconds = report.held.empty() ? kIdleWaitSeconds : kBusyWaitSeconds;
  return report;
}

absl::Status WorkerLoop::SynchronizeOnce() {
  WorkerReport report;
  {
    const MutexLock lock(mutex_);
    report = MakeReport(nullptr);
  }
  const absl::StatusOr<WorkerOrders> orders = link_.Synchronize(report);
  if (!orders.ok()) {
    const MutexLock lock(mutex_);
    is_asking_ = false;
    return orders.status();
  }
  if (orders->is_wedged) {
    return absl::AbortedError("a task goes on after the server has told it to stop");
  }
  Release(Follow(*orders));
  return absl::OkStatus();
}

std::vector<Lease> WorkerLoop::Follow(const WorkerOrders& orders) {
  const MutexLock lock(mutex_);
  is_asking_ = false;
  is_out_of_reach_ = false;
  next_sync_ = In(std::max(kShortestPauseSeconds, orders.next_sync_seconds));
  lease_seconds_ = orders.lease_seconds;
  for (const Lease& lease : orders.lost) {
    const auto found = running_.find(lease);
    if (found != running_.end()) {
      spdlog::info("event=lease_lost worker={} job={} task={} epoch={}", options_.worker.value,
                   lease.task.job.value, lease.task.number, lease.epoch);
      found->second.stop.request_stop();
    }
  }
  std::vector<Lease> refused;
  for (const GrantedTask& granted : orders.grants) {
    if (takes_tasks_) {
      Start(granted);
    } else if (!running_.contains(granted.lease)) {
      refused.push_back(granted.lease);
    }
  }
  return refused;
}

void WorkerLoop::Release(const std::vector<Lease>& leases) {
  for (const Lease& lease : leases) {
    const absl::Status said = link_.ReleaseTask(options_.worker, lease);
    if (!said.ok()) {  // It runs out by itself.
      spdlog::warn("event=report_failed worker={} job={} task={} epoch={} error=\"{}\"",
                   options_.worker.value, lease.task.job.value, lease.task.number, lease.epoch,
                   std::string(said.message()));
    }
  }
}

void WorkerLoop::Start(const GrantedTask& granted) {
  Running& running = running_[granted.lease];
  if (running.thread.joinable()) {
    return;  // It was told twice.
  }
  spdlog::debug("event=task_started worker={} job={} task={} stage=\"{}\" epoch={}",
                options_.worker.value, granted.lease.task.job.value, granted.task.number,
                granted.task.stage, granted.lease.epoch);
  running.thread = std::thread([this, granted, stop = running.stop.get_token(),
                                ticks = running.ticks] { RunSlot(granted, stop, *ticks); });
}

void WorkerLoop::RunSlot(const GrantedTask& granted,
                         const std::stop_token& stop,
                         std::atomic<int64_t>& ticks) {
  TaskHooks hooks;
  hooks.on_begin = [&] {
    spdlog::debug("event=task_begun worker={} job={} task={} stage=\"{}\" epoch={}",
                  options_.worker.value, granted.lease.task.job.value, granted.task.number,
                  granted.task.stage, granted.lease.epoch);
  };
  hooks.on_computed = [&] { NoteComputed(granted.lease); };
  const absl::StatusOr<TaskResult> result = runner_.Run(granted.task, stop, ticks, hooks);
  Report(granted.lease, result, stop);
  MutexLock lock(mutex_);
  running_.at(granted.lease).finished = true;
  slot_freed_.NotifyAll();
}

void WorkerLoop::Report(const Lease& lease,
                        absl::StatusOr<TaskResult> result,
                        const std::stop_token& stop) {
  RetryPause retry;
  while (true) {
    absl::Status said;
    if (result.ok()) {
      said = Complete(lease, *result);
    } else if (result.status().code() == absl::StatusCode::kCancelled) {
      said = link_.ReleaseTask(options_.worker, lease);
    } else {
      spdlog::warn("event=task_failed worker={} job={} task={} epoch={} error=\"{}\"",
                   options_.worker.value, lease.task.job.value, lease.task.number, lease.epoch,
                   std::string(result.status().message()));
      said = link_.FailTask(options_.worker, lease, result.status());
    }
    if (said.ok()) {
      NoteEnded(lease, result);
      return;
    }
    spdlog::warn("event=report_failed worker={} job={} task={} epoch={} error=\"{}\"",
                 options_.worker.value, lease.task.job.value, lease.task.number, lease.epoch,
                 std::string(said.message()));
    if (stop.stop_requested()) {
      return;  // The lease is no longer ours, or runs out: another worker does the task.
    }
    if (!IsTransient(said)) {
      if (!result.ok()) {
        return;
      }
      // The server does not take this result: the task has failed here. If its output is not in the
      // store (any more), another try may help.
      result = ErrorReason(said) == "BLOB_MISSING" ? absl::AbortedError(said.message()) : said;
      continue;
    }
    MutexLock lock(mutex_);
    slot_freed_.WaitUntil(mutex_, In(retry.Next(lease_seconds_)));
  }
}

absl::Status WorkerLoop::Complete(const Lease& lease, const TaskResult& result) {
  std::optional<WorkerReport> next;
  {
    const MutexLock lock(mutex_);
    if (takes_tasks_ && !is_asking_) {
      next = MakeReport(&lease);
    }
  }
  const absl::StatusOr<std::optional<WorkerOrders>> orders =
      link_.CompleteTask(options_.worker, lease, result, next);
  if (!next) {
    return orders.status();
  }
  if (!orders.ok() || !orders->has_value() || (*orders)->is_wedged) {
    const MutexLock lock(mutex_);
    is_asking_ = false;
    has_news_ = true;
    return orders.status();
  }
  Release(Follow(**orders));
  const MutexLock lock(mutex_);
  running_.at(lease).is_told = true;
  // Whoever has a slot free asks again, waiting this time.
  has_news_ = has_news_ || ((*orders)->grants.empty() && (*orders)->next_sync_seconds == 0);
  return absl::OkStatus();
}

void WorkerLoop::NoteComputed(const Lease& lease) {
  const MutexLock lock(mutex_);
  running_.at(lease).computed = true;
  const auto left = std::count_if(running_.begin(), running_.end(), [](const auto& held) {
    return !held.second.finished && !held.second.computed;
  });
  if (left < options_.slots) {  // A slot stands empty.
    has_news_ = true;
  } else if (left == options_.slots && !is_out_of_reach_) {
    next_sync_ = std::min(next_sync_, In(kPatienceSeconds));
  }
  slot_freed_.NotifyAll();
}

void WorkerLoop::NoteEnded(const Lease& lease, const absl::StatusOr<TaskResult>& result) {
  const double seconds = result.ok() ? result->seconds : 0;
  spdlog::debug("event=task_reported worker={} job={} task={} epoch={} seconds={:.3f} status={}",
                options_.worker.value, lease.task.job.value, lease.task.number, lease.epoch,
                seconds, absl::StatusCodeToString(result.status().code()));
  const MutexLock lock(mutex_);
  if (result.ok()) {
    ++figures_.completed;
    figures_.seconds += seconds;
  } else if (absl::IsCancelled(result.status())) {
    ++figures_.released;
  } else {
    ++figures_.failed;
  }
}

WorkerFigures WorkerLoop::Figures() {
  const MutexLock lock(mutex_);
  WorkerFigures figures = figures_;
  figures.slots = options_.slots;
  figures.held = std::ssize(running_);
  for (const auto& [lease, running] : running_) {
    figures.computing += !running.finished && *running.ticks != HeldTask::kNotBegun ? 1 : 0;
  }
  return figures;
}

void WorkerLoop::Reap() {
  for (auto it = running_.begin(); it != running_.end();) {
    if (it->second.finished) {
      it->second.thread.join();  // Only leaves its last lock; does not block.
      has_news_ = has_news_ || !it->second.is_told;
      it = running_.erase(it);
    } else {
      ++it;
    }
  }
}

void WorkerLoop::Drain() {
  const auto deadline = In(options_.drain_seconds);
  MutexLock lock(mutex_);
  Reap();
  while (!running_.empty() && slot_freed_.WaitUntil(mutex_, deadline)) {
    Reap();
  }
  for (auto& [lease, running] : running_) {
    running.stop.request_stop();
  }
  while (!running_.empty()) {
    Reap();
    if (!running_.empty()) {
      slot_freed_.Wait(mutex_);
    }
  }
}

}  // namespace cohort
