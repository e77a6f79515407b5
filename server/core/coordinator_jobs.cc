// The life of a job in the coordinator: taken up, gone on with, held, ended.
#include <algorithm>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

/// Tasks looked up at once, and how many times under one hold of the lock.
constexpr int64_t kTasksPerLookUp = 256;
constexpr int kLookUpsPerCall = 16;
/// More ready tasks than this are not looked for: no cluster empties them between two results.
constexpr int64_t kEnoughReady = 8192;
constexpr size_t kNamedFailures = 3;

/// "task 3 (align 1): no such blob"; of many the first ones.
std::string FailureText(const std::map<int64_t, std::string>& given_up) {
  std::string text;
  if (given_up.size() > 1) {
    text = absl::StrCat(given_up.size(), " tasks failed: ");
  }
  size_t named = 0;
  for (const auto& [number, why] : given_up) {
    if (named == kNamedFailures) {
      absl::StrAppend(&text, "; ...");
      break;
    }
    absl::StrAppend(&text, named++ == 0 ? "" : "; ", "task ", number, why);
  }
  return text;
}

absl::Status WrongState(const Job& job, const char* wanted, const char* reason) {
  return WithReason(
      absl::FailedPreconditionError(absl::StrCat(
          "job ", job.id.value, " is ", std::string(JobStateName(job.state)), ", not ", wanted)),
      reason);
}

}  // namespace

absl::Status Coordinator::Advance(ActiveJob& active) {
  for (int round = 0; round < kLookUpsPerCall && !IsFinal(active.job.state); ++round) {
    for (const TaskRange& range : active.plan->TakeReady()) {
      active.unlooked.InsertRange(range.first, range.count);
    }
    if (active.plan->Done()) {
      return EndJob(active, JobState::kSucceeded, "");
    }
    if (active.unlooked.empty() || scheduler_.OpenCount(active.job.id) >= kEnoughReady) {
      break;
    }
    COHORT_RETURN_IF_ERROR(LookUp(active));
  }
  return EndIfStuck(active);
}

absl::Status Coordinator::LookUp(ActiveJob& active) {
  std::vector<int64_t> numbers;
  active.unlooked.ForEachOfFirst(kTasksPerLookUp,
                                 [&](int64_t number) { numbers.push_back(number); });
  std::vector<Task> tasks;
  for (const int64_t number : numbers) {
    // What a fresh job may know is what it has done itself, before it was put back.
    if (!active.job.spec.fresh || active.earlier_attempts.contains(number)) {
      tasks.push_back(active.plan->MakeTask(number));
    }
  }
  COHORT_ASSIGN_OR_RETURN(const auto known, FindKnown(active, tasks));
  const auto attempts_of = [&active](int64_t number) {
    const auto earlier = active.earlier_attempts.find(number);
    return earlier == active.earlier_attempts.end() ? TaskAttempts() : earlier->second;
  };
  std::vector<JobTask> records;
  records.reserve(known.size());
  for (const auto& [number, result] : known) {
    TaskRecord record;
    record.number = number;
    record.epoch = attempts_of(number).epoch;
    record.result = result;
    records.push_back({.job = active.job.id, .task = std::move(record)});
  }
  if (!records.empty()) {
    // Before anything is changed here: if the disk is full, they are looked up again.
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(records, {}));
  }
  for (const int64_t number : numbers) {
    const TaskAttempts attempts = attempts_of(number);
    active.unlooked.Erase(number);
    active.earlier_attempts.erase(number);
    if (!known.contains(number)) {
      scheduler_.AddTask({.job = active.job.id, .number = number}, attempts);
    } else if (attempts.epoch == 0) {
      ++active.reused;
    }
  }
  if (records.empty()) {
    return absl::OkStatus();
  }
  totals_.tasks_reused += std::ssize(records);
  for (const JobTask& record : records) {
    const absl::Status verdict = active.plan->TaskFinished(record.task.number, *record.task.result);
    if (!verdict.ok()) {
      return EndJob(active, JobState::kFailed, std::string(verdict.message()));
    }
  }
  Touch(active);
  return absl::OkStatus();
}

absl::StatusOr<std::map<int64_t, TaskResult>> Coordinator::FindKnown(
    const ActiveJob& active, const std::vector<Task>& tasks) {
  std::map<int64_t, TaskResult> known;
  std::map<std::string, int64_t> number_of;
  std::vector<std::string> keys;
  const bool fresh = active.job.spec.fresh;
  for (const Task& task : tasks) {
    if (task.kind == TaskKind::kIngest) {
      if (fresh) {
        continue;  // Nobody knows when it was done.
      }
      COHORT_ASSIGN_OR_RETURN(std::optional<TaskResult> result, FindIngested(task));
      if (result) {
        known.emplace(task.number, *std::move(result));
      }
      continue;
    }
    keys.push_back(action_keys_.Of(task));
    number_of[keys.back()] = task.number;
  }
  COHORT_ASSIGN_OR_RETURN(
      const auto actions,
      catalog_.FindActions(keys, fresh ? active.job.created_unix_ms : Catalog::kAnyTime));
  for (const auto& [key, result] : actions) {
    const int64_t number = number_of.at(key);
    // A blob that is gone makes the result unknown; so would one that does not fit.
    if (CheckOutputs(result).ok() && active.plan->Check(number, result).ok()) {
      known.emplace(number, result);
    }
  }
  return known;
}

absl::StatusOr<std::optional<TaskResult>> Coordinator::FindIngested(const Task& task) {
  TaskResult result;
  for (const TaskMesh& mesh : task.meshes) {
    COHORT_ASSIGN_OR_RETURN(std::optional<IngestedMesh> known,
                            catalog_.FindIngested(mesh.blob, task.position_bits));
    if (!known) {
      return std::nullopt;
    }
    known->index = mesh.index;
    result.ingested.push_back(*std::move(known));
  }
  if (!CheckOutputs(result).ok()) {
    return std::nullopt;
  }
  return result;
}

absl::Status Coordinator::EndIfStuck(ActiveJob& active) {
  const bool is_stuck = !active.given_up.empty() && !IsFinal(active.job.state) &&
                        active.unlooked.empty() && scheduler_.OpenCount(active.job.id) == 0;
  return is_stuck ? EndJob(active, JobState::kFailed, FailureText(active.given_up))
                  : absl::OkStatus();
}

absl::Status Coordinator::EndJob(ActiveJob& active, JobState state, const std::string& error) {
  Job ended = active.job;
  ended.state = state;
  ended.error = error;
  ended.finished_unix_ms = WallMs();
  if (state == JobState::kSucceeded && ended.started_unix_ms == 0) {
    ended.started_unix_ms = ended.created_unix_ms;  // All was known.
  }
  ended.progress.waiting_for.clear();
  UpdateProgress(active, ended);
  ended.counters = active.plan->TotalCounters();
  ++ended.version;
  // A retry needs what was kept of a reference job.
  const JobOutputs& outputs = state == JobState::kSucceeded ? active.plan->Outputs() : active.kept;
  COHORT_RETURN_IF_ERROR(catalog_.FinishJob(ended, outputs, active.plan->Meshes()));
  spdlog::info("event=job_ended job={} state={} error=\"{}\"", ended.id.value, JobStateName(state),
               error);
  ++totals_.jobs_ended[state];
  active.job = ended;
  scheduler_.RemoveJob(ended.id);
  changes_.push_back(ended);
  return absl::OkStatus();
}

absl::StatusOr<Job> Coordinator::CancelJob(const JobId& id) {
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    const auto running = active_.find(id);
    if (running != active_.end()) {
      COHORT_RETURN_IF_ERROR(EndJob(running->second, JobState::kCancelled, ""));
      changes = TakeChanges();
    }
  }
  work_.NotifyAll();
  Notify(changes);
  return catalog_.GetJob(id);
}

absl::StatusOr<Job> Coordinator::PauseJob(const JobId& id) {
  return SetPaused(id, JobState::kPaused);
}

absl::StatusOr<Job> Coordinator::ResumeJob(const JobId& id) {
  return SetPaused(id, JobState::kRunning);
}

absl::StatusOr<Job> Coordinator::SetPaused(const JobId& id, JobState state) {
  Job job;
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    const auto running = active_.find(id);
    if (running == active_.end()) {
      COHORT_ASSIGN_OR_RETURN(job, catalog_.GetJob(id));
      return WrongState(job, "queued, running or paused", "JOB_FINISHED");
    }
    ActiveJob& active = running->second;
    const bool is_paused = active.job.state == JobState::kPaused;
    if (is_paused != (state == JobState::kPaused)) {
      Job next = active.job;
      next.state =
          state == JobState::kRunning && next.started_unix_ms == 0 ? JobState::kQueued : state;
      ++next.version;
      COHORT_RETURN_IF_ERROR(catalog_.UpdateJob(next));
      active.job = next;
      ServeJob(active);
      changes_.push_back(active.job);
    }
    job = active.job;
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return job;
}

absl::StatusOr<Job> Coordinator::RetryJob(const JobId& id) {
  COHORT_ASSIGN_OR_RETURN(Job job, GetJob(id));
  if (job.state == JobState::kSucceeded) {
    COHORT_ASSIGN_OR_RETURN(std::optional<Job> mended, MakeLostResults(job));
    if (mended) {
      return *std::move(mended);
    }
  }
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    const auto running = active_.find(id);
    if (running != active_.end()) {
      return WrongState(running->second.job, "failed or cancelled", "JOB_NOT_FAILED");
    }
    COHORT_ASSIGN_OR_RETURN(job, catalog_.GetJob(id));
    if (job.state != JobState::kFailed && job.state != JobState::kCancelled) {
      return WrongState(job, "failed or cancelled", "JOB_NOT_FAILED");
    }
    std::vector<JobTask> again;
    COHORT_RETURN_IF_ERROR(catalog_.VisitTasks(id, [&](const TaskRecord& record) {
      if (!record.result) {
        TaskRecord fresh;
        fresh.number = record.number;
        fresh.epoch = record.epoch;
        again.push_back({.job = id, .task = std::move(fresh)});
      }
      return absl::OkStatus();
    }));
    job.state = job.started_unix_ms == 0 ? JobState::kQueued : JobState::kRunning;
    job.error.clear();
    job.finished_unix_ms = 0;
    ++job.version;
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(again, std::span(&job, 1)));
    COHORT_RETURN_IF_ERROR(RecoverJob(job));
    job = active_.at(id).job;
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return job;
}

absl::Status Coordinator::DeleteJob(const JobId& id) {
  const MutexLock lock(mutex_);
  return catalog_.DeleteJob(id);
}

void Coordinator::ServeJob(const ActiveJob& active) {
  scheduler_.SetJob(active.job.id, {.priority = active.job.spec.priority,
                                    .is_paused = active.job.state == JobState::kPaused,
                                    .traits_of = [plan = active.plan.get()](int64_t number) {
                                      return plan->TraitsOf(number);
                                    }});
}

void Coordinator::UpdateProgress(const ActiveJob& active, Job& job) {
  Progress progress = active.plan->CurrentProgress();
  progress.stages = std::move(job.progress.stages);
  progress.waiting_for = std::move(job.progress.waiting_for);
  progress.tasks_reused = active.reused;
  progress.tasks_given_up = std::ssize(active.given_up);
  job.progress = std::move(progress);
}

void Coordinator::NoteStage(const std::string& stage, Job& job) const {
  std::vector<StageTime>& stages = job.progress.stages;
  auto time = std::find_if(stages.begin(), stages.end(),
                           [&](const StageTime& known) { return known.name == stage; });
  if (time == stages.end()) {
    time = stages.insert(stages.end(), {.name = stage, .started_unix_ms = WallMs()});
  }
  time->finished_unix_ms = WallMs();
}

void Coordinator::Touch(ActiveJob& active) {
  UpdateProgress(active, active.job);
  active.job.counters = active.plan->TotalCounters();
  const auto& meshes = active.plan->Meshes();
  active.job.rejected_meshes = std::count_if(
      meshes.begin(), meshes.end(), [](const JobMesh& mesh) { return !mesh.rejection.empty(); });
  ++active.job.version;
  changes_.push_back(active.job);
}

std::vector<Job> Coordinator::TakeChanges() {
  std::erase_if(active_, [](const auto& entry) { return IsFinal(entry.second.job.state); });
  return std::exchange(changes_, {});
}

}  // namespace cohort
