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
  const std::stop_callback wake(stop, [this] {
    link_.CancelSynchronize();
    slot_freed_.NotifyAll();
  });
  RetryPause retry;
  while (!stop.stop_requested()) {
    absl::Status status = SynchronizeOnce(stop);
    double pause_seconds = next_sync_seconds_;
    if (stop.stop_requested()) {
      break;
    }
    if (status.ok()) {
      retry.Reset();
    } else if (status.code() == absl::StatusCode::kFailedPrecondition ||
               status.code() == absl::StatusCode::kAborted) {
      return status;
    } else {
      pause_seconds = retry.Next(lease_seconds_);
      spdlog::warn("event=sync_failed worker={} retry_seconds={} error=\"{}\"",
                   options_.worker.value, pause_seconds, std::string(status.message()));
    }
    MutexLock lock(mutex_);
    Reap();
    const auto deadline = In(pause_seconds);
    // The server says when to call again; sooner when there is news, if it can be reached.
    while (!stop.stop_requested() && (!status.ok() || !has_news_) &&
           slot_freed_.WaitUntil(mutex_, deadline)) {
      Reap();
    }
  }
  return absl::OkStatus();
}

WorkerReport WorkerLoop::MakeReport() {
  WorkerReport report;
  report.worker = options_.worker;
  report.build = options_.build;
  report.slots = options_.slots;
  report.instruction_set = options_.instruction_set;
  int written = 0;
  {
    MutexLock lock(mutex_);
    Reap();
    has_news_ = false;
    for (const auto& [lease, running] : running_) {
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

absl::Status WorkerLoop::SynchronizeOnce(const std::stop_token& stop) {
  COHORT_ASSIGN_OR_RETURN(const WorkerOrders orders, link_.Synchronize(MakeReport()));
  next_sync_seconds_ = std::max(kShortestPauseSeconds, orders.next_sync_seconds);
  lease_seconds_ = orders.lease_seconds;
  if (orders.is_wedged) {
    return absl::AbortedError("a task goes on after the server has told it to stop");
  }
  MutexLock lock(mutex_);
  for (const Lease& lease : orders.lost) {
    const auto found = running_.find(lease);
    if (found != running_.end()) {
      spdlog::info("event=lease_lost worker={} job={} task={} epoch={}", options_.worker.value,
                   lease.task.job.value, lease.task.number, lease.epoch);
      found->second.stop.request_stop();
    }
  }
  if (!stop.stop_requested()) {
    for (const GrantedTask& granted : orders.grants) {
      Start(granted);
    }
  }
  return absl::OkStatus();
}

void WorkerLoop::Start(const GrantedTask& granted) {
  Running& running = running_[granted.lease];
  if (running.thread.joinable()) {
    return;  // The server repeats a grant whose answer was lost.
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
      said = link_.CompleteTask(options_.worker, lease, *result);
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

void WorkerLoop::NoteComputed(const Lease& lease) {
  const MutexLock lock(mutex_);
  running_.at(lease).computed = true;
  const bool has_next = std::any_of(running_.begin(), running_.end(), [](const auto& held) {
    return !held.second.finished && *held.second.ticks == HeldTask::kNotBegun;
  });
  if (!has_next) {  // Asked for now, it is there when the slot would stand empty.
    has_news_ = true;
    slot_freed_.NotifyAll();
  }
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
      it = running_.erase(it);
      has_news_ = true;
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
