// What workers ask of the coordinator: to be given tasks, and to keep them.
#include <algorithm>
#include <chrono>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

/// How often a waiting call looks whether leases have run out or its caller has gone.
constexpr std::chrono::milliseconds kWaitStep(250);
/// A younger call's caller is taken to be there: to ask gRPC costs as much as to answer.
constexpr std::chrono::milliseconds kMayHaveGone(100);
/// A worker without work that may not wait here calls again after this for each hundred workers.
constexpr double kIdleSecondsPerHundred = 0.5;
constexpr char kLostTooOften[] = " was lost with too many workers; see their logs (out of memory?)";
/// A worker silent for this many lease times is no longer listed.
constexpr double kListedLeaseTimes = 10;

double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

absl::StatusOr<WorkerOrders> Coordinator::Synchronize(const WorkerReport& report,
                                                      const std::function<bool()>& is_cancelled) {
  if (report.build != options_.build) {
    return WithReason(
        absl::FailedPreconditionError("worker " + report.worker.value + " is build " +
                                      report.build + ", this server is build " + options_.build +
                                      ": install the same version on both"),
        "BUILD_MISMATCH");
  }
  const MonotonicTime called = clock_.Now();
  const MonotonicTime deadline =
      called + std::chrono::milliseconds(static_cast<int64_t>(report.wait_seconds * 1000));
  QueuedReport queued{.report = report,
                      .is_cancelled = is_cancelled,
                      .arrived = called,
                      .orders = {},
                      .status = {}};
  std::vector<Job> changes;
  double waited_seconds = 0;  // For a task; not for the server.
  const auto enqueue = [&] {
    queued.is_answered = false;
    const MutexLock lock(queue_mutex_);
    reports_.push_back(&queued);
  };
  while (true) {
    enqueue();
    const MutexLock lock(mutex_);
    if (queued.is_answered && clock_.Now() < deadline && MayWait(queued)) {
      // Answered by another call, before this one had the lock: what has become ready since then
      // would not wake it.
      enqueue();
    }
    if (!queued.is_answered) {
      AnswerReports({});
    }
    std::vector<Job> more = TakeChanges();
    changes.insert(changes.end(), more.begin(), more.end());
    const MonotonicTime now = clock_.Now();
    if (now >= deadline || !MayWait(queued)) {
      break;
    }
    waiting_.push_back(&queued);
    work_.WaitUntil(mutex_, std::min(deadline, now + kWaitStep));
    std::erase(waiting_, &queued);
    waited_seconds += SecondsBetween(now, clock_.Now());
    if (MustReturn(queued)) {  // A result that came in has brought its answer.
      break;
    }
  }
  synchronize_timer_.Add(SecondsBetween(called, clock_.Now()) - waited_seconds);
  Notify(changes);
  COHORT_RETURN_IF_ERROR(queued.status);
  return queued.orders;
}

void Coordinator::AnswerReports(std::span<QueuedReport* const> besides) {
  std::vector<QueuedReport*> batch(besides.begin(), besides.end());
  {
    const MutexLock lock(queue_mutex_);
    batch.insert(batch.end(), reports_.begin(), reports_.end());
    reports_.clear();
  }
  const MonotonicTime now = clock_.Now();
  std::vector<TaskId> given_up = scheduler_.Expire(now);
  GrantWrite write;
  for (QueuedReport* queued : batch) {
    queued->orders = {};
    TakeReport(*queued, now, given_up);
    if (HasGone(*queued, now)) {
      queued->status =
          absl::CancelledError(absl::StrCat("worker ", queued->report.worker.value, " has gone"));
      continue;
    }
    if (MayHaveTasks(*queued) && !queued->orders.is_wedged) {
      for (const Lease& lease : GrantTasks(queued->report, 0, now)) {
        AddGrant(lease, *queued, write);
      }
    }
  }
  NoteLost();
  NoteReady(now, std::ssize(write.tasks));
  absl::Status saved = GiveUp(given_up, kLostTooOften);
  if (saved.ok() && !write.tasks.empty()) {
    saved = catalog_.SaveGrants(write.tasks, JobsOf(write));
  }
  for (QueuedReport* queued : batch) {
    queued->orders.next_sync_seconds = NextSyncSeconds(*queued);
    if (!saved.ok()) {
      WithdrawGrants(*queued, now);
      queued->status = saved;
    }
  }
}

bool Coordinator::HasGone(const QueuedReport& queued, MonotonicTime now) {
  return now - queued.arrived >= kMayHaveGone && queued.is_cancelled();
}

void Coordinator::TakeReport(QueuedReport& queued,
                             MonotonicTime now,
                             std::vector<TaskId>& given_up) {
  queued.is_answered = true;
  queued.orders.lease_seconds = options_.scheduler.lease_seconds;
  NoteWorker(queued.report, now);
  Renewal renewal = scheduler_.Renew(queued.report.worker, queued.report.held, now);
  queued.orders.lost = std::move(renewal.lost);
  queued.orders.is_wedged = renewal.is_wedged;
  given_up.insert(given_up.end(), renewal.given_up.begin(), renewal.given_up.end());
  for (const Lease& lease : scheduler_.TakeBackUnheard(queued.report.worker, queued.arrived)) {
    spdlog::info("event=grant_unheard worker={} job={} task={} epoch={}",
                 queued.report.worker.value, lease.task.job.value, lease.task.number, lease.epoch);
  }
}

bool Coordinator::MayHaveTasks(const QueuedReport& queued) const {
  return !stopping_ && no_space_.empty() && !queued.report.draining;
}

bool Coordinator::MustReturn(const QueuedReport& queued) {
  const WorkerOrders& orders = queued.orders;
  return !queued.status.ok() || !orders.grants.empty() || !orders.lost.empty() || orders.is_wedged;
}

bool Coordinator::MayWait(const QueuedReport& queued) const {
  return !MustReturn(queued) && queued.report.free_slots > 0 && !queued.report.draining &&
         !stopping_ && std::ssize(waiting_) < options_.most_waiting;
}

void Coordinator::WithdrawGrants(const QueuedReport& queued, MonotonicTime now) {
  for (const GrantedTask& granted : queued.orders.grants) {
    scheduler_.Release(granted.lease, now);
  }
}

Coordinator::GrantWrite Coordinator::GrantWithResults(std::span<QueuedCompletion* const> results,
                                                      MonotonicTime now) {
  GrantWrite write;
  for (const QueuedCompletion* result : results) {
    // A task that has come back from a silent worker, whose result comes all the same, must not be
    // given out again.
    if (!scheduler_.LeaseOf(result->lease.task)) {
      return write;
    }
  }
  for (const QueuedCompletion* result : results) {
    QueuedReport* next = result->next;
    if (next == nullptr || next->report.build != options_.build || !MayHaveTasks(*next) ||
        HasGone(*next, now)) {
      continue;
    }
    // With fewer tasks the answer may follow from the results: what they make ready, and what is
    // worth a second copy.
    const int wanted = next->report.free_slots + next->report.spare_slots;
    if (wanted == 0 || scheduler_.GrantableCount() < wanted) {
      continue;
    }
    for (const Lease& lease : GrantTasks(next->report, std::ssize(results), now)) {
      AddGrant(lease, *next, write);
    }
  }
  return write;
}

void Coordinator::AnswerAfter(std::span<QueuedCompletion* const> results) {
  std::vector<QueuedReport*> open;
  for (const QueuedCompletion* result : results) {
    QueuedReport* next = result->next;
    if (next != nullptr && !next->is_answered && next->report.build == options_.build) {
      open.push_back(next);
    }
  }
  // One that has its answer, and has not had the lock since, keeps it.
  std::copy_if(waiting_.begin(), waiting_.end(), std::back_inserter(open),
               [](const QueuedReport* queued) { return !MustReturn(*queued); });
  if (open.empty()) {
    return;
  }
  AnswerReports(open);
  if (std::any_of(waiting_.begin(), waiting_.end(),
                  [](const QueuedReport* queued) { return MustReturn(*queued); })) {
    work_.NotifyAll();
  }
}

void Coordinator::AnswerNext(QueuedReport& queued, MonotonicTime now) {
  std::vector<TaskId> given_up;
  TakeReport(queued, now, given_up);
  queued.status = GiveUp(given_up, kLostTooOften);
  if (queued.orders.is_wedged || !queued.status.ok()) {
    WithdrawGrants(queued, now);
  }
  std::vector<GrantedTask> granted = std::move(queued.orders.grants);
  queued.orders.grants.clear();
  for (GrantedTask& grant : granted) {
    if (scheduler_.IsCurrent(grant.lease)) {  // Else a result has ended its job.
      queued.orders.grants.push_back(std::move(grant));
    }
  }
  queued.orders.next_sync_seconds = NextSyncSeconds(queued);
}

std::vector<Job> Coordinator::JobsOf(const GrantWrite& write) const {
  std::vector<Job> jobs;
  for (const JobId& id : write.jobs) {
    jobs.push_back(active_.at(id).job);
  }
  return jobs;
}

void Coordinator::NoteWorker(const WorkerReport& report, MonotonicTime now) {
  WorkerStatus& status = workers_[report.worker];
  if (status.worker.value.empty()) {
    status.worker = report.worker;
    status.first_seen_unix_ms = WallMs();
    spdlog::info("event=worker_joined worker={} slots={} isa={}", report.worker.value, report.slots,
                 report.instruction_set);
  }
  status.instruction_set = report.instruction_set;
  status.slots = report.slots;
  status.is_draining = report.draining;
  status.running.clear();
  for (const HeldTask& held : report.held) {
    status.running.push_back({.held = held, .stage = "", .seconds = 0});
  }
  last_seen_[report.worker] = now;
}

std::vector<Lease> Coordinator::GrantTasks(const WorkerReport& report,
                                           int64_t ending,
                                           MonotonicTime now) {
  // Near the end of a stage a task held ready by one worker is missing to another.
  const bool plenty =
      scheduler_.GrantableCount() - report.free_slots > scheduler_.LeasedCount() - ending;
  const int count = report.free_slots + (plenty ? report.spare_slots : 0);
  return scheduler_.Grant(report.worker, count, now);
}

void Coordinator::AddGrant(const Lease& lease, QueuedReport& queued, GrantWrite& write) {
  ActiveJob& active = active_.at(lease.task.job);
  queued.orders.grants.push_back(
      {.lease = lease, .task = active.plan->MakeTask(lease.task.number)});
  TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
  record.worker = queued.report.worker.value;
  write.tasks.push_back({.job = lease.task.job, .task = std::move(record)});
  const size_t stages = active.job.progress.stages.size();
  NoteStage(queued.orders.grants.back().task.stage, active.job);
  if (active.job.state == JobState::kQueued) {
    active.job.state = JobState::kRunning;
    active.job.started_unix_ms = WallMs();
    Touch(active);
    write.jobs.insert(lease.task.job);
  } else if (active.job.progress.stages.size() > stages) {
    write.jobs.insert(lease.task.job);
  }
}

double Coordinator::NextSyncSeconds(const QueuedReport& queued) const {
  const auto granted = std::ssize(queued.orders.grants);
  const bool has_free_slots = queued.report.free_slots > granted && !queued.report.draining;
  if (has_free_slots && std::ssize(waiting_) >= options_.most_waiting) {
    return std::min(kIdleSecondsPerHundred * static_cast<double>(workers_.size()) / 100,
                    options_.scheduler.lease_seconds / 6);
  }
  return has_free_slots ? 0 : options_.scheduler.lease_seconds / 6;
}

absl::Status Coordinator::Tick() {
  std::vector<Job> changes;
  absl::Status status;
  const absl::Status space = CheckSpace();
  {
    const MutexLock lock(mutex_);
    NoteSpace(space);
    status = TakeUpStanding();
    const MonotonicTime now = clock_.Now();
    status.Update(GiveUp(scheduler_.Expire(now), kLostTooOften));
    for (auto& [id, active] : active_) {
      if (!IsFinal(active.job.state)) {
        status.Update(Advance(active));
      }
    }
    const double forget = kListedLeaseTimes * options_.scheduler.lease_seconds;
    for (auto seen = last_seen_.begin(); seen != last_seen_.end();) {
      if (SecondsBetween(seen->second, now) <= forget) {
        ++seen;
        continue;
      }
      spdlog::info("event=worker_gone worker={} silent_seconds={:.0f}", seen->first.value,
                   SecondsBetween(seen->second, now));
      workers_.erase(seen->first);
      seen = last_seen_.erase(seen);
    }
    NoteLost();
    NoteReady(now, 0);
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return status;
}

}  // namespace cohort
