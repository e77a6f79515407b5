#include "server/scheduling/scheduler.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace cohort {
namespace {

/// Doubling stops here: 2^16 retry times are a day for the default of a second.
constexpr int kMaxDoublings = 16;
/// A second copy is worth its while only where this many tasks of the stage tell what is usual.
constexpr int64_t kLeastSamples = 5;
/// A task that a worker has held for this long without beginning it is free for others.
constexpr double kQueueSeconds = 1;
/// How many of the tasks longest out are looked at for a second copy.
constexpr int kCopyCandidates = 32;

MonotonicTime::duration Seconds(double seconds) {
  return std::chrono::duration_cast<MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

void Scheduler::SetJob(const JobId& job, JobOptions options) {
  JobTasks& tasks = jobs_[job];
  tasks.options = std::move(options);
  if (tasks.options.is_paused || tasks.ready.empty()) {
    jobs_with_ready_.erase(job);
  } else {
    jobs_with_ready_.insert(job);
  }
}

void Scheduler::AddTasks(const JobId& job, int64_t first, int64_t count) {
  JobTasks& tasks = jobs_[job];
  ready_count_ -= tasks.ready.Size();
  tasks.ready.InsertRange(first, count);
  ready_count_ += tasks.ready.Size();
  if (!tasks.ready.empty() && !tasks.options.is_paused) {
    jobs_with_ready_.insert(job);
  }
}

void Scheduler::AddTask(const TaskId& task, const TaskAttempts& attempts) {
  if (IsKnown(task)) {
    return;
  }
  if (attempts.epoch > 0) {
    jobs_[task.job].entries[task.number].attempts = attempts;
  }
  AddTasks(task.job, task.number, 1);
}

void Scheduler::RestoreLease(const TaskId& task,
                             const TaskAttempts& attempts,
                             const WorkerId& worker,
                             MonotonicTime now) {
  if (IsKnown(task)) {
    return;
  }
  jobs_[task.job].entries[task.number].attempts = attempts;
  AddTasks(task.job, task.number, 1);
  AddCopy(task, {.worker = worker,
                 .epoch = attempts.epoch,
                 .granted = now,
                 .until = LeaseEnd(now),
                 .ticks = {},
                 .got_on = now});
}

std::vector<Lease> Scheduler::Grant(const WorkerId& worker, int count, MonotonicTime now) {
  WakeWaiting(now);
  std::vector<Lease> granted;
  for (int i = 0; i < count; ++i) {
    const std::optional<JobId> job = NextJob();
    if (job) {
      last_served_ = *job;
      granted.push_back(GrantTo(worker, {*job, PickTask(*job, worker)}, now));
      continue;
    }
    const std::optional<TaskId> slow = FindSlowTask(worker, now);
    if (!slow) {
      break;
    }
    granted.push_back(GrantTo(worker, *slow, now));
    ++second_copy_count_;
  }
  return granted;
}

Renewal Scheduler::Renew(const WorkerId& worker,
                         const std::vector<HeldTask>& held,
                         MonotonicTime now) {
  Renewal renewal;
  std::map<Lease, MonotonicTime> told;
  const auto told_before = told_.find(worker);
  const auto refuse = [&](const Lease& lease) {
    MonotonicTime since = now;
    if (told_before != told_.end()) {
      const auto found = told_before->second.find(lease);
      since = found == told_before->second.end() ? now : found->second;
    }
    renewal.is_wedged |= SecondsBetween(since, now) >= options_.evict_seconds;
    renewal.lost.push_back(lease);
    told.emplace(lease, since);
  };
  for (const HeldTask& task : held) {
    Copy* copy = FindCopy(task.lease);
    if (copy == nullptr || copy->worker != worker) {
      refuse(task.lease);
      continue;
    }
    if (copy->ticks != task.ticks || task.ticks == HeldTask::kNotBegun) {
      copy->ticks = task.ticks;
      copy->got_on = now;
    } else if (SecondsBetween(copy->got_on, now) >= options_.stall_seconds) {
      if (Lose(task.lease)) {
        renewal.given_up.push_back(task.lease.task);
      }
      refuse(task.lease);
      continue;
    }
    NoteHeard(worker, task.lease);
    expiries_.erase({copy->until, task.lease.task, copy->epoch});
    copy->until = LeaseEnd(now);
    expiries_.emplace(copy->until, task.lease.task, copy->epoch);
  }
  if (told.empty()) {
    told_.erase(worker);
  } else {
    told_[worker] = std::move(told);
  }
  return renewal;
}

std::vector<Lease> Scheduler::TakeBackUnheard(const WorkerId& worker, MonotonicTime reported) {
  std::vector<Lease> unheard;
  if (const auto found = unheard_.find(worker); found != unheard_.end()) {
    for (const auto& [lease, granted] : found->second) {
      if (SecondsBetween(granted, reported) >= options_.unheard_seconds) {
        unheard.push_back(lease);
      }
    }
  }
  for (const Lease& lease : unheard) {
    DropCopy(lease, Entry::State::kReady);
  }
  return unheard;
}

CompletionVerdict Scheduler::Complete(const Lease& lease, MonotonicTime now) {
  if (!IsKnown(lease.task)) {
    return CompletionVerdict::kNotActive;
  }
  JobTasks& tasks = jobs_.at(lease.task.job);
  if (tasks.done.Contains(lease.task.number)) {
    return CompletionVerdict::kDuplicate;
  }
  const Entry* entry = Find(lease.task);
  if (entry != nullptr && entry->state == Entry::State::kGivenUp) {
    return CompletionVerdict::kNotActive;
  }
  if (const Copy* copy = FindCopy(lease); copy != nullptr) {
    tasks.durations[TraitsOf(lease.task).stage].Add(SecondsBetween(copy->granted, now));
  }
  // Whatever the epoch: the task is pure, so the first result is as good as any later one.
  while (entry != nullptr && !entry->copies.empty()) {
    DropCopy({lease.task, entry->copies.back().epoch}, Entry::State::kReady);
    entry = Find(lease.task);
  }
  MoveTo(lease.task, Entry::State::kGivenUp);  // Out of every index.
  tasks.entries.erase(lease.task.number);
  tasks.done.Insert(lease.task.number);
  return CompletionVerdict::kAccepted;
}

bool Scheduler::Release(const Lease& lease, MonotonicTime /*now*/) {
  if (FindCopy(lease) == nullptr) {
    return false;
  }
  DropCopy(lease, Entry::State::kReady);
  return true;
}

bool Scheduler::Fail(const Lease& lease, bool retryable, MonotonicTime now) {
  if (FindCopy(lease) == nullptr) {
    return false;
  }
  Entry& entry = *Find(lease.task);
  const int failures = ++entry.attempts.failures;
  if (!retryable || failures >= options_.max_failures) {
    // Its other copy would fail in the same way; if not, its result comes too late.
    while (entry.copies.size() > 1) {
      DropCopy({lease.task, entry.copies.back().epoch == lease.epoch ? entry.copies.front().epoch
                                                                     : entry.copies.back().epoch},
               Entry::State::kReady);
    }
    DropCopy(lease, Entry::State::kGivenUp);
    return true;
  }
  const double wait = std::ldexp(options_.retry_seconds, std::min(failures - 1, kMaxDoublings));
  DropCopy(lease, Entry::State::kWaiting, now + Seconds(wait));
  return false;
}

std::vector<TaskId> Scheduler::Expire(MonotonicTime now) {
  std::vector<TaskId> given_up;
  while (!expiries_.empty() && std::get<0>(*expiries_.begin()) <= now) {
    const auto [until, task, epoch] = *expiries_.begin();
    if (Lose({task, epoch})) {
      given_up.push_back(task);
    }
  }
  return given_up;
}

std::optional<TaskId> Scheduler::FindSlowTask(const WorkerId& worker, MonotonicTime now) const {
  int looked_at = 0;
  for (const auto& [granted, task] : single_copies_) {
    if (++looked_at > kCopyCandidates) {
      break;
    }
    const Copy& copy = Find(task)->copies.front();
    if (copy.worker != worker && !jobs_.at(task.job).options.is_paused && IsSlow(task, copy, now)) {
      return task;
    }
  }
  return std::nullopt;
}

bool Scheduler::IsSlow(const TaskId& task, const Copy& copy, MonotonicTime now) const {
  const double seconds = SecondsBetween(copy.granted, now);
  if (copy.ticks == HeldTask::kNotBegun) {
    return seconds >= kQueueSeconds;
  }
  const auto& durations = jobs_.at(task.job).durations;
  const auto usual = durations.find(TraitsOf(task).stage);
  if (usual == durations.end() || usual->second.Count() < kLeastSamples) {
    return false;
  }
  return seconds >=
         std::max(options_.least_copy_seconds, options_.copy_factor * usual->second.Quantile(0.95));
}

MonotonicTime Scheduler::LeaseEnd(MonotonicTime now) const {
  return now + Seconds(options_.lease_seconds);
}

}  // namespace cohort
