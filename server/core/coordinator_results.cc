// What workers tell the coordinator of their tasks: done, given back, failed.
#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

bool IsRetryable(absl::StatusCode code) {
  // These fail in the same way anywhere: the input or the request is at fault.
  return code != absl::StatusCode::kInvalidArgument && code != absl::StatusCode::kDataLoss &&
         code != absl::StatusCode::kFailedPrecondition;
}

double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

absl::Status Coordinator::CheckOutputs(const TaskResult& result) {
  std::vector<Digest> outputs = {result.output,    result.second_output, result.poses,
                                 result.variation, result.placed,        result.fields};
  for (const IngestedMesh& mesh : result.ingested) {
    outputs.push_back(mesh.blob);
  }
  for (const SymmetricCopy& copy : result.copies) {
    outputs.push_back(copy.blob);
  }
  for (const Digest& output : outputs) {
    if (output.empty()) {
      continue;
    }
    COHORT_ASSIGN_OR_RETURN(const bool exists, store_.Contains(output));
    if (!exists) {
      return WithReason(absl::FailedPreconditionError("output " + output.Hex() +
                                                      " is not in the server's store; do server "
                                                      "and worker use the same one?"),
                        "BLOB_MISSING");
    }
  }
  return absl::OkStatus();
}

ActiveJob* Coordinator::FindOpen(const TaskId& task) {
  const auto found = active_.find(task.job);
  const bool is_open =
      found != active_.end() && !IsFinal(found->second.job.state) && scheduler_.IsOpen(task);
  return is_open ? &found->second : nullptr;
}

absl::StatusOr<bool> Coordinator::CompleteTask(const WorkerId& worker,
                                               const Lease& lease,
                                               const TaskResult& result) {
  QueuedCompletion queued{.worker = worker, .lease = lease, .result = result};
  return QueueCompletion(queued);
}

absl::StatusOr<CompletionAnswer> Coordinator::CompleteTask(
    const WorkerId& worker,
    const Lease& lease,
    const TaskResult& result,
    const WorkerReport& next,
    const std::function<bool()>& is_cancelled) {
  WorkerReport report = next;
  report.wait_seconds = 0;
  QueuedReport queued_next{.report = report,
                           .is_cancelled = is_cancelled,
                           .arrived = clock_.Now(),
                           .orders = {},
                           .status = {}};
  QueuedCompletion queued{.worker = worker, .lease = lease, .result = result, .next = &queued_next};
  CompletionAnswer answer;
  COHORT_ASSIGN_OR_RETURN(answer.taken, QueueCompletion(queued));
  if (!queued_next.is_answered) {
    absl::StatusOr<WorkerOrders> orders = Synchronize(report, is_cancelled);
    if (orders.ok()) {
      answer.orders = *std::move(orders);
    }
  } else if (queued_next.status.ok()) {
    answer.orders = std::move(queued_next.orders);
  }
  return answer;
}

absl::StatusOr<bool> Coordinator::QueueCompletion(QueuedCompletion& queued) {
  const MonotonicTime called = clock_.Now();
  COHORT_RETURN_IF_ERROR(CheckOutputs(queued.result));
  std::vector<Job> changes;
  {
    const MutexLock lock(queue_mutex_);
    completions_.push_back(&queued);
  }
  {
    const MutexLock lock(mutex_);
    if (!queued.outcome) {
      TakeCompletions();
    }
    changes = TakeChanges();
    // Before anybody hears of the change: who then looks at the figures finds this call among them.
    complete_timer_.Add(SecondsBetween(called, clock_.Now()));
  }
  Notify(changes);
  return *queued.outcome;
}

void Coordinator::TakeCompletions() {
  std::vector<QueuedCompletion*> batch;
  {
    const MutexLock lock(queue_mutex_);
    batch.swap(completions_);
  }
  std::vector<Completion> writes = WhatIsWanted(batch);
  if (batch.empty()) {
    return;
  }
  const MonotonicTime now = clock_.Now();
  GrantWrite grants = GrantWithResults(batch, now);
  for (Completion& write : writes) {
    write.job = active_.at(write.job.id).job;
    ++write.job.version;
    grants.jobs.erase(write.job.id);
  }
  const absl::Status saved =
      catalog_.SaveCompletions(writes, WallMs(), grants.tasks, JobsOf(grants));
  if (saved.ok()) {
    TakeIn(batch, now);
  } else {
    for (QueuedCompletion* queued : batch) {
      queued->outcome = saved;
      if (queued->next != nullptr) {
        WithdrawGrants(*queued->next, now);
      }
    }
  }
  if (!grants.tasks.empty()) {
    NoteLost();
    NoteReady(now, std::ssize(grants.tasks));
  }
  if (saved.ok()) {
    AnswerAfter(batch);
  }
}

std::vector<Completion> Coordinator::WhatIsWanted(std::vector<QueuedCompletion*>& batch) {
  std::vector<Completion> writes;
  std::set<TaskId> seen;
  std::erase_if(batch, [&](QueuedCompletion* queued) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    queued->outcome = false;
    const ActiveJob* open = FindOpen(queued->lease.task);
    // Of a job that was started over only the holder's result counts: a lease of the earlier plan
    // that a power failure made the catalog forget may have the same epoch.
    const bool is_ours = open != nullptr && (!open->is_started_over ||
                                             scheduler_.HolderOf(queued->lease) == queued->worker);
    if (!is_ours || !seen.insert(queued->lease.task).second) {
      ++totals_.tasks_superseded;
      spdlog::info("event=result_superseded job={} task={} epoch={} worker={}",
                   queued->lease.task.job.value, queued->lease.task.number, queued->lease.epoch,
                   queued->worker.value);
      return true;
    }
    absl::StatusOr<Completion> completion = CompletionOf(*queued);
    if (!completion.ok()) {
      queued->outcome = completion.status();
      return true;
    }
    writes.push_back(*std::move(completion));
    return false;
  });
  return writes;
}

void Coordinator::TakeIn(std::span<QueuedCompletion* const> results, MonotonicTime now) {
  // On disk: from here on memory follows, and nothing below can undo it.
  std::set<JobId> jobs;
  for (QueuedCompletion* queued : results) {
    queued->outcome = true;
    Apply(*queued);
    jobs.insert(queued->lease.task.job);
  }
  for (const JobId& job : jobs) {
    const absl::Status advanced = Advance(active_.at(job));
    if (!advanced.ok()) {  // Tick tries again.
      spdlog::error("event=job_stands job={} error=\"{}\"", job.value,
                    std::string(advanced.message()));
    }
  }
  for (const QueuedCompletion* queued : results) {
    if (queued->next != nullptr && !queued->next->orders.grants.empty()) {
      AnswerNext(*queued->next, now);
    }
  }
}

absl::StatusOr<Completion> Coordinator::CompletionOf(const QueuedCompletion& queued) {
  const int64_t number = queued.lease.task.number;
  ActiveJob& active = active_.at(queued.lease.task.job);
  COHORT_RETURN_IF_ERROR(active.plan->Check(number, queued.result));
  Completion completion;
  NoteStage(active.plan->StageOf(number), active.job);
  completion.job.id = active.job.id;
  completion.task = RecordOf(number, scheduler_.AttemptsOf(queued.lease.task));
  completion.task.result = queued.result;
  completion.task.worker = queued.worker.value;
  const Task task = active.plan->MakeTask(number);
  if (task.kind != TaskKind::kIngest) {
    completion.action_key = action_keys_.Of(task);
  }
  for (const IngestedMesh& mesh : queued.result.ingested) {
    const auto input = std::find_if(task.meshes.begin(), task.meshes.end(),
                                    [&](const TaskMesh& m) { return m.index == mesh.index; });
    if (input != task.meshes.end()) {
      completion.ingested.emplace_back(input->blob, mesh);
    }
  }
  return completion;
}

void Coordinator::Apply(const QueuedCompletion& queued) {
  const TaskId& task = queued.lease.task;
  ActiveJob& active = active_.at(task.job);
  scheduler_.Complete(queued.lease, clock_.Now());
  if (const auto worker = workers_.find(queued.worker); worker != workers_.end()) {
    ++worker->second.tasks_done;
    worker->second.busy_seconds += queued.result.seconds;
  }
  if (IsFinal(active.job.state)) {
    return;  // By a result of the same batch.
  }
  const std::string stage = active.plan->StageOf(task.number);
  totals_.NoteDone(StageKind(stage), queued.result.seconds);
  rates_.Note(TaskRates::KindOf(active.job.spec, stage), active.plan->CostOf(task.number),
              queued.result.seconds);
  const absl::Status verdict = active.plan->TaskFinished(task.number, queued.result);
  Touch(active);
  if (!verdict.ok()) {
    const absl::Status ended = EndJob(active, JobState::kFailed, std::string(verdict.message()));
    if (!ended.ok()) {  // After a restart the same results end it in the same way.
      spdlog::error("event=job_stands job={} error=\"{}\"", task.job.value,
                    std::string(ended.message()));
    }
  }
}

absl::Status Coordinator::ReleaseTask(const WorkerId& worker, const Lease& lease) {
  {
    const MutexLock lock(mutex_);
    if (!scheduler_.Release(lease, clock_.Now())) {
      return absl::OkStatus();
    }
    TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
    record.last_error = "released by " + worker.value;
    const JobTask task{.job = lease.task.job, .task = std::move(record)};
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(std::span(&task, 1), {}));
  }
  work_.NotifyAll();
  return absl::OkStatus();
}

absl::Status Coordinator::FailTask(const WorkerId& worker,
                                   const Lease& lease,
                                   const absl::Status& failure) {
  const std::optional<Digest> unreadable = UnreadableBlob(failure);
  if (unreadable) {
    COHORT_ASSIGN_OR_RETURN(const bool is_seen_to, HandleDamagedBlob(lease, *unreadable));
    if (is_seen_to) {
      return absl::OkStatus();
    }
  }
  if (absl::IsResourceExhausted(failure) && !CheckSpace().ok()) {
    return ReleaseTask(worker, lease);
  }
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    const auto found = active_.find(lease.task.job);
    if (found == active_.end() || !scheduler_.IsCurrent(lease)) {
      return absl::OkStatus();  // Cancelled, or another worker has the task by now.
    }
    ActiveJob& active = found->second;
    if (const auto status = workers_.find(worker); status != workers_.end()) {
      ++status->second.tasks_failed;
    }
    ++totals_.tasks_failed;
    const std::string message(failure.message());
    const bool is_retryable = unreadable.has_value() || IsRetryable(failure.code());
    if (scheduler_.Fail(lease, is_retryable, clock_.Now())) {
      COHORT_RETURN_IF_ERROR(GiveUp({lease.task}, ": " + message));
    } else {
      TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
      record.last_error = worker.value + ": " + message;
      const JobTask task{.job = lease.task.job, .task = std::move(record)};
      COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(std::span(&task, 1), {}));
    }
    spdlog::warn("event=task_failed job={} task={} epoch={} stage=\"{}\" worker={} error=\"{}\"",
                 lease.task.job.value, lease.task.number, lease.epoch,
                 IsFinal(active.job.state) ? "" : active.plan->StageOf(lease.task.number),
                 worker.value, message);
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return absl::OkStatus();
}

absl::Status Coordinator::GiveUp(const std::vector<TaskId>& tasks, const std::string& why) {
  for (const TaskId& task : tasks) {
    const auto found = active_.find(task.job);
    if (found == active_.end() || IsFinal(found->second.job.state)) {
      continue;
    }
    ActiveJob& active = found->second;
    const std::string text = absl::StrCat(" (", active.plan->StageOf(task.number), ")", why);
    TaskRecord record = RecordOf(task.number, scheduler_.AttemptsOf(task));
    record.given_up = true;
    record.last_error = text;
    active.given_up.emplace(task.number, text);
    ++totals_.tasks_given_up;
    spdlog::error("event=task_given_up job={} task={} epoch={} failures={} losses={} error=\"{}\"",
                  task.job.value, task.number, record.epoch, record.failures, record.losses, text);
    Touch(active);
    const JobTask written{.job = task.job, .task = std::move(record)};
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(std::span(&written, 1), std::span(&active.job, 1)));
    COHORT_RETURN_IF_ERROR(EndIfStuck(active));
  }
  return absl::OkStatus();
}

}  // namespace cohort
