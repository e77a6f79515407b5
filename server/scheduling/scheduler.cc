#include "server/scheduling/scheduler.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace cohort {
namespace {

/// Doubling stops here: 2^16 retry times are a day for the default of a second.
constexpr int kMaxDoublings = 16;

MonotonicTime::duration Seconds(double seconds) {
  return std::chrono::duration_cast<MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

}  // namespace

void Scheduler::AddTask(const TaskId& task, const TaskAttempts& attempts) {
  const auto [found, added] = jobs_[task.job].tasks.try_emplace(task.number);
  if (added) {
    found->second.attempts = attempts;
    Enter(task, found->second);
  }
}

void Scheduler::RestoreLease(const TaskId& task,
                             const TaskAttempts& attempts,
                             const WorkerId& worker,
                             MonotonicTime now) {
  const auto [found, added] = jobs_[task.job].tasks.try_emplace(task.number);
  if (added) {
    Entry& entry = found->second;
    entry.attempts = attempts;
    entry.worker = worker;
    entry.state = Entry::State::kLeased;
    entry.until = LeaseEnd(now);
    Enter(task, entry);
  }
}

std::vector<Lease> Scheduler::Grant(const WorkerId& worker, int count, MonotonicTime now) {
  WakeWaiting(now);
  std::vector<Lease> granted;
  for (int i = 0; i < count; ++i) {
    const std::optional<JobId> job = NextJob();
    if (!job) {
      break;
    }
    last_served_ = *job;
    JobTasks& tasks = jobs_.at(*job);
    const TaskId task{*job, *tasks.ready.begin()};
    Entry& entry = tasks.tasks.at(task.number);
    MoveTo(task, entry, Entry::State::kLeased, LeaseEnd(now));
    entry.worker = worker;
    ++entry.attempts.epoch;
    granted.push_back({task, entry.attempts.epoch});
  }
  return granted;
}

std::vector<Lease> Scheduler::Renew(const WorkerId& worker,
                                    const std::vector<Lease>& held,
                                    MonotonicTime now) {
  std::vector<Lease> lost;
  for (const Lease& lease : held) {
    Entry* entry = FindLeased(lease);
    if (entry != nullptr && entry->worker == worker) {
      MoveTo(lease.task, *entry, Entry::State::kLeased, LeaseEnd(now));
    } else {
      lost.push_back(lease);
    }
  }
  return lost;
}

CompletionVerdict Scheduler::Complete(const Lease& lease) {
  Entry* entry = Find(lease.task);
  if (entry == nullptr || entry->state == Entry::State::kGivenUp) {
    return CompletionVerdict::kNotActive;
  }
  if (entry->state == Entry::State::kDone) {
    return CompletionVerdict::kDuplicate;
  }
  // Whatever the epoch: the task is pure, so the first result is as good as any later one.
  MoveTo(lease.task, *entry, Entry::State::kDone);
  return CompletionVerdict::kAccepted;
}

bool Scheduler::Release(const Lease& lease, MonotonicTime /*now*/) {
  Entry* entry = FindLeased(lease);
  if (entry == nullptr) {
    return false;
  }
  MoveTo(lease.task, *entry, Entry::State::kReady);
  return true;
}

bool Scheduler::Fail(const Lease& lease, bool retryable, MonotonicTime now) {
  Entry* entry = FindLeased(lease);
  if (entry == nullptr) {
    return false;
  }
  const int failures = ++entry->attempts.failures;
  if (!retryable || failures >= options_.max_failures) {
    MoveTo(lease.task, *entry, Entry::State::kGivenUp);
    return true;
  }
  const double wait = std::ldexp(options_.retry_seconds, std::min(failures - 1, kMaxDoublings));
  MoveTo(lease.task, *entry, Entry::State::kWaiting, now + Seconds(wait));
  return false;
}

std::vector<TaskId> Scheduler::Expire(MonotonicTime now) {
  std::vector<TaskId> given_up;
  while (!leased_.empty() && leased_.begin()->first <= now) {
    const TaskId task = leased_.begin()->second;
    Entry& entry = *Find(task);
    if (++entry.attempts.losses >= options_.max_losses) {
      MoveTo(task, entry, Entry::State::kGivenUp);
      given_up.push_back(task);
    } else {
      MoveTo(task, entry, Entry::State::kReady);
    }
  }
  return given_up;
}

void Scheduler::RemoveJob(const JobId& job) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) {
    return;
  }
  for (const auto& [number, entry] : found->second.tasks) {
    Leave({job, number}, entry);
  }
  jobs_.erase(found);
}

bool Scheduler::HasReadyTask(MonotonicTime now) const {
  return !jobs_with_ready_.empty() || (!waiting_.empty() && waiting_.begin()->first <= now);
}

TaskAttempts Scheduler::AttemptsOf(const TaskId& task) const {
  const Entry* entry = Find(task);
  return entry == nullptr ? TaskAttempts() : entry->attempts;
}

std::optional<Lease> Scheduler::LeaseOf(const TaskId& task) const {
  const Entry* entry = Find(task);
  if (entry == nullptr || entry->state != Entry::State::kLeased) {
    return std::nullopt;
  }
  return Lease{task, entry->attempts.epoch};
}

int64_t Scheduler::ReadyCount() const {
  return ready_count_ + static_cast<int64_t>(waiting_.size());
}

int64_t Scheduler::LeasedCount() const {
  return static_cast<int64_t>(leased_.size());
}

Scheduler::Entry* Scheduler::Find(const TaskId& task) {
  return const_cast<Entry*>(std::as_const(*this).Find(task));
}

const Scheduler::Entry* Scheduler::Find(const TaskId& task) const {
  const auto job = jobs_.find(task.job);
  if (job == jobs_.end()) {
    return nullptr;
  }
  const auto found = job->second.tasks.find(task.number);
  return found == job->second.tasks.end() ? nullptr : &found->second;
}

Scheduler::Entry* Scheduler::FindLeased(const Lease& lease) {
  Entry* entry = Find(lease.task);
  const bool current = entry != nullptr && entry->state == Entry::State::kLeased &&
                       entry->attempts.epoch == lease.epoch;
  return current ? entry : nullptr;
}

void Scheduler::MoveTo(const TaskId& task, Entry& entry, Entry::State state, MonotonicTime until) {
  Leave(task, entry);
  entry.state = state;
  entry.until = until;
  if (state != Entry::State::kLeased) {
    entry.worker = WorkerId();
  }
  Enter(task, entry);
}

void Scheduler::Enter(const TaskId& task, const Entry& entry) {
  switch (entry.state) {
    case Entry::State::kReady:
      jobs_.at(task.job).ready.insert(task.number);
      jobs_with_ready_.insert(task.job);
      ++ready_count_;
      break;
    case Entry::State::kWaiting:
      waiting_.emplace(entry.until, task);
      break;
    case Entry::State::kLeased:
      leased_.emplace(entry.until, task);
      break;
    case Entry::State::kDone:
    case Entry::State::kGivenUp:
      break;
  }
}

void Scheduler::Leave(const TaskId& task, const Entry& entry) {
  switch (entry.state) {
    case Entry::State::kReady: {
      std::set<int64_t>& ready = jobs_.at(task.job).ready;
      ready.erase(task.number);
      if (ready.empty()) {
        jobs_with_ready_.erase(task.job);
      }
      --ready_count_;
      break;
    }
    case Entry::State::kWaiting:
      waiting_.erase({entry.until, task});
      break;
    case Entry::State::kLeased:
      leased_.erase({entry.until, task});
      break;
    case Entry::State::kDone:
    case Entry::State::kGivenUp:
      break;
  }
}

void Scheduler::WakeWaiting(MonotonicTime now) {
  while (!waiting_.empty() && waiting_.begin()->first <= now) {
    const TaskId task = waiting_.begin()->second;
    MoveTo(task, *Find(task), Entry::State::kReady);
  }
}

std::optional<JobId> Scheduler::NextJob() const {
  if (jobs_with_ready_.empty()) {
    return std::nullopt;
  }
  const auto next = jobs_with_ready_.upper_bound(last_served_);
  return next == jobs_with_ready_.end() ? *jobs_with_ready_.begin() : *next;
}

MonotonicTime Scheduler::LeaseEnd(MonotonicTime now) const {
  return now + Seconds(options_.lease_seconds);
}

}  // namespace cohort
