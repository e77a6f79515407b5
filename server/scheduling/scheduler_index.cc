// The half of the scheduler that keeps its counts and indexes true.
#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "server/scheduling/scheduler.h"

namespace cohort {
namespace {

constexpr int64_t kPickWindow = 48;  ///< Ready tasks among which a worker's own are looked for.
/// Tasks that cost less than this share of the dearest are left for the end of a stage, when
/// workers are to finish together.
constexpr double kLikeCost = 0.7;
constexpr size_t kMemoryLength = 32;    ///< Groups of meshes that a worker is taken to have still.
constexpr size_t kMostMemories = 4096;  ///< Workers known; beyond, all are forgotten.

}  // namespace

void Scheduler::RemoveJob(const JobId& job) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) {
    return;
  }
  JobTasks& tasks = found->second;
  for (auto& [number, entry] : tasks.entries) {
    const TaskId task{job, number};
    if (entry.state == Entry::State::kWaiting) {
      waiting_.erase({entry.until, task});
    }
    for (const Copy& copy : entry.copies) {
      RemoveFromIndexes(task, copy);
    }
  }
  ready_count_ -= tasks.ready.Size();
  leased_count_ -= tasks.leased;
  jobs_with_ready_.erase(job);
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
  if (entry == nullptr || entry->copies.empty()) {
    return std::nullopt;
  }
  return Lease{task, entry->copies.back().epoch};
}

std::optional<WorkerId> Scheduler::HolderOf(const Lease& lease) const {
  const Copy* copy = FindCopy(lease);
  return copy == nullptr ? std::nullopt : std::optional(copy->worker);
}

std::optional<MonotonicTime> Scheduler::GrantedAt(const Lease& lease) const {
  const Copy* copy = FindCopy(lease);
  return copy == nullptr ? std::nullopt : std::optional(copy->granted);
}

bool Scheduler::IsOpen(const TaskId& task) const {
  const auto job = jobs_.find(task.job);
  if (job == jobs_.end()) {
    return false;
  }
  const Entry* entry = Find(task);
  return entry == nullptr ? job->second.ready.Contains(task.number)
                          : entry->state != Entry::State::kGivenUp;
}

int64_t Scheduler::ReadyCount() const {
  return ready_count_ + static_cast<int64_t>(waiting_.size());
}

int64_t Scheduler::GrantableCount() const {
  int64_t count = 0;
  for (const JobId& job : jobs_with_ready_) {
    count += jobs_.at(job).ready.Size();
  }
  return count;
}

int64_t Scheduler::OpenCount(const JobId& job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end()
             ? 0
             : found->second.ready.Size() + found->second.waiting + found->second.leased;
}

bool Scheduler::IsKnown(const TaskId& task) const {
  const auto job = jobs_.find(task.job);
  return job != jobs_.end() &&
         (job->second.ready.Contains(task.number) || job->second.done.Contains(task.number) ||
          job->second.entries.contains(task.number));
}

Scheduler::Entry* Scheduler::Find(const TaskId& task) {
  return const_cast<Entry*>(std::as_const(*this).Find(task));
}

const Scheduler::Entry* Scheduler::Find(const TaskId& task) const {
  const auto job = jobs_.find(task.job);
  if (job == jobs_.end()) {
    return nullptr;
  }
  const auto found = job->second.entries.find(task.number);
  return found == job->second.entries.end() ? nullptr : &found->second;
}

Scheduler::Copy* Scheduler::FindCopy(const Lease& lease) {
  return const_cast<Copy*>(std::as_const(*this).FindCopy(lease));
}

const Scheduler::Copy* Scheduler::FindCopy(const Lease& lease) const {
  const Entry* entry = Find(lease.task);
  if (entry == nullptr) {
    return nullptr;
  }
  const auto found = std::find_if(entry->copies.begin(), entry->copies.end(),
                                  [&](const Copy& copy) { return copy.epoch == lease.epoch; });
  return found == entry->copies.end() ? nullptr : &*found;
}

void Scheduler::MoveTo(const TaskId& task, Entry::State state, MonotonicTime until) {
  JobTasks& tasks = jobs_.at(task.job);
  Entry& entry = tasks.entries[task.number];
  switch (entry.state) {
    case Entry::State::kReady:
      if (tasks.ready.Contains(task.number)) {
        tasks.ready.Erase(task.number);
        --ready_count_;
        if (tasks.ready.empty()) {
          jobs_with_ready_.erase(task.job);
        }
      }
      break;
    case Entry::State::kWaiting:
      waiting_.erase({entry.until, task});
      --tasks.waiting;
      break;
    case Entry::State::kLeased:
      --tasks.leased;
      --leased_count_;
      break;
    case Entry::State::kGivenUp:
      break;
  }
  entry.state = state;
  entry.until = until;
  switch (state) {
    case Entry::State::kReady:
      AddTasks(task.job, task.number, 1);
      break;
    case Entry::State::kWaiting:
      waiting_.emplace(until, task);
      ++tasks.waiting;
      break;
    case Entry::State::kLeased:
      ++tasks.leased;
      ++leased_count_;
      break;
    case Entry::State::kGivenUp:
      break;
  }
}

void Scheduler::AddCopy(const TaskId& task, Copy copy) {
  const Entry* known = Find(task);
  if (known == nullptr || known->state != Entry::State::kLeased) {
    MoveTo(task, Entry::State::kLeased);
  }
  Entry& entry = *Find(task);
  expiries_.emplace(copy.until, task, copy.epoch);
  unheard_[copy.worker].emplace(Lease{task, copy.epoch}, copy.granted);
  if (entry.copies.empty()) {
    single_copies_.emplace(copy.granted, task);
  } else {
    single_copies_.erase({entry.copies.front().granted, task});
  }
  entry.copies.push_back(std::move(copy));
}

void Scheduler::DropCopy(const Lease& lease, Entry::State then, MonotonicTime until) {
  Entry& entry = *Find(lease.task);
  RemoveFromIndexes(lease.task, *FindCopy(lease));
  std::erase_if(entry.copies, [&](const Copy& other) { return other.epoch == lease.epoch; });
  if (entry.copies.empty()) {
    MoveTo(lease.task, then, until);
  } else {
    single_copies_.emplace(entry.copies.front().granted, lease.task);
  }
}

void Scheduler::RemoveFromIndexes(const TaskId& task, const Copy& copy) {
  expiries_.erase({copy.until, task, copy.epoch});
  single_copies_.erase({copy.granted, task});
  NoteHeard(copy.worker, {task, copy.epoch});
}

void Scheduler::NoteHeard(const WorkerId& worker, const Lease& lease) {
  const auto found = unheard_.find(worker);
  if (found != unheard_.end()) {
    found->second.erase(lease);
    if (found->second.empty()) {
      unheard_.erase(found);
    }
  }
}

bool Scheduler::Lose(const Lease& lease) {
  Entry& entry = *Find(lease.task);
  // What was not begun did its worker no harm.
  const Copy& copy = *FindCopy(lease);
  lost_.push_back({.lease = lease, .worker = copy.worker});
  if (copy.ticks != HeldTask::kNotBegun) {
    ++entry.attempts.losses;
  }
  const bool given_up = entry.attempts.losses >= options_.max_losses && entry.copies.size() == 1;
  DropCopy(lease, given_up ? Entry::State::kGivenUp : Entry::State::kReady);
  return given_up;
}

Lease Scheduler::GrantTo(const WorkerId& worker, const TaskId& task, MonotonicTime now) {
  const int64_t epoch = AttemptsOf(task).epoch + 1;
  AddCopy(task, {.worker = worker,
                 .epoch = epoch,
                 .granted = now,
                 .until = LeaseEnd(now),
                 .ticks = {},
                 .got_on = now});
  Find(task)->attempts.epoch = epoch;
  Remember(worker, task);
  return {task, epoch};
}

TaskTraits Scheduler::TraitsOf(const TaskId& task) const {
  const auto& traits_of = jobs_.at(task.job).options.traits_of;
  return traits_of == nullptr ? TaskTraits() : traits_of(task.number);
}

int64_t Scheduler::PickTask(const JobId& job, const WorkerId& worker) const {
  const JobTasks& tasks = jobs_.at(job);
  int64_t best = tasks.ready.First();
  const auto memory = memories_.find(worker);
  if (memory == memories_.end() || tasks.options.traits_of == nullptr) {
    return best;
  }
  const int64_t stage = TraitsOf({job, best}).stage;
  std::vector<std::pair<int64_t, TaskTraits>> choice;
  double dearest = 0;
  tasks.ready.ForEachOfFirst(kPickWindow, [&](int64_t number) {
    const TaskTraits traits = TraitsOf({job, number});
    if (traits.stage == stage) {  // Stages of one step come one after the other.
      choice.emplace_back(number, traits);
      dearest = std::max(dearest, traits.cost);
    }
  });
  int best_score = -1;
  for (const auto& [number, traits] : choice) {
    if (traits.cost < kLikeCost * dearest) {
      continue;
    }
    int score = 0;
    for (const int64_t read : traits.reads) {
      const bool has =
          read != TaskTraits::kNothing && std::find(memory->second.begin(), memory->second.end(),
                                                    std::pair(job, read)) != memory->second.end();
      score += has ? 1 : 0;
    }
    if (score > best_score) {
      best_score = score;
      best = number;
    }
  }
  return best;
}

void Scheduler::Remember(const WorkerId& worker, const TaskId& task) {
  if (memories_.size() >= kMostMemories) {
    memories_.clear();
    told_.clear();
  }
  for (const int64_t read : TraitsOf(task).reads) {
    if (read != TaskTraits::kNothing) {
      Memory& memory = memories_[worker];
      std::erase(memory, std::pair(task.job, read));
      memory.emplace_back(task.job, read);
      if (memory.size() > kMemoryLength) {
        memory.pop_front();
      }
    }
  }
}

void Scheduler::WakeWaiting(MonotonicTime now) {
  while (!waiting_.empty() && waiting_.begin()->first <= now) {
    const TaskId task = waiting_.begin()->second;
    MoveTo(task, Entry::State::kReady);
  }
}

std::optional<JobId> Scheduler::NextJob() const {
  // Cyclic order after the job served last, so that the first of equals changes.
  std::optional<JobId> best;
  const auto rank = [&](const JobId& job) {
    const JobTasks& tasks = jobs_.at(job);
    return std::tuple(-int64_t{tasks.options.priority}, tasks.leased, job <= last_served_, job);
  };
  for (const JobId& job : jobs_with_ready_) {
    if (!best || rank(job) < rank(*best)) {
      best = job;
    }
  }
  return best;
}

}  // namespace cohort
