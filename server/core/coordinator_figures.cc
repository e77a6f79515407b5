// What those who watch over a server ask of the coordinator.
#include "server/core/coordinator_figures.h"

#include <algorithm>
#include <chrono>

#include <spdlog/spdlog.h>

#include "common/jobs/lease.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

double SecondsSince(MonotonicTime then, MonotonicTime now) {
  return std::chrono::duration<double>(now - then).count();
}

}  // namespace

void Coordinator::NoteReady(MonotonicTime now, int64_t granted) {
  if (!scheduler_.HasReadyTask(now)) {
    ready_since_.reset();
  } else if (granted > 0 || !ready_since_) {
    ready_since_ = now;
  }
}

void Coordinator::NoteLost() {
  for (const LostLease& lost : scheduler_.TakeLost()) {
    ++totals_.tasks_lost;
    spdlog::warn("event=task_lost job={} task={} epoch={} worker={}", lost.lease.task.job.value,
                 lost.lease.task.number, lost.lease.epoch, lost.worker.value);
  }
}

std::vector<WorkerStatus> Coordinator::ListWorkers() {
  const MutexLock lock(mutex_);
  const MonotonicTime now = clock_.Now();
  std::vector<WorkerStatus> workers;
  workers.reserve(workers_.size());
  for (const auto& [id, status] : workers_) {
    workers.push_back(status);
    workers.back().silent_seconds = SecondsSince(last_seen_.at(id), now);
    for (RunningTask& running : workers.back().running) {
      const Lease& lease = running.held.lease;
      if (const auto granted = scheduler_.GrantedAt(lease)) {
        running.stage = active_.at(lease.task.job).plan->StageOf(lease.task.number);
        running.seconds = SecondsSince(*granted, now);
      }
    }
  }
  return workers;
}

CoordinatorFigures Coordinator::Figures() {
  CoordinatorFigures figures;
  figures.synchronize = synchronize_timer_.Times();
  figures.complete = complete_timer_.Times();
  figures.catalog_writes = catalog_.WriteTimes();
  for (const JobState state : {JobState::kQueued, JobState::kRunning, JobState::kPaused}) {
    figures.jobs[state] = 0;
  }
  const MutexLock lock(mutex_);
  const MonotonicTime now = clock_.Now();
  NoteReady(now, 0);
  figures.tasks_ready = scheduler_.ReadyCount();
  figures.tasks_leased = scheduler_.LeasedCount();
  figures.second_copies = scheduler_.SecondCopyCount();
  figures.ready_wait_seconds = ready_since_ ? SecondsSince(*ready_since_, now) : 0;
  figures.totals = totals_;
  for (const auto& [id, active] : active_) {
    if (!IsFinal(active.job.state)) {
      ++figures.jobs[active.job.state];
    }
  }
  for (const auto& [id, worker] : workers_) {
    if (SecondsSince(last_seen_.at(id), now) > options_.scheduler.lease_seconds) {
      continue;
    }
    ++figures.workers;
    figures.workers_draining += worker.is_draining ? 1 : 0;
    figures.slots += worker.is_draining ? 0 : worker.slots;
    const auto begun = std::count_if(
        worker.running.begin(), worker.running.end(),
        [](const RunningTask& task) { return task.held.ticks != HeldTask::kNotBegun; });
    figures.slots_busy += std::min<int64_t>(begun, worker.slots);
  }
  return figures;
}

}  // namespace cohort
