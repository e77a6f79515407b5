// The half of the coordinator that deals with tasks and workers.
#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

/// How often a waiting call looks whether leases have run out or its caller has gone.
constexpr std::chrono::milliseconds kWaitStep(250);

bool IsRetryable(absl::StatusCode code) {
  // These fail in the same way anywhere: the input or the request is at fault.
  return code != absl::StatusCode::kInvalidArgument && code != absl::StatusCode::kDataLoss &&
         code != absl::StatusCode::kFailedPrecondition;
}

/// Feeds finished tasks back into a fresh plan, in number order: a task has a higher number than
/// those it needs. The others become the open tasks.
/// @return as JobPlan::TaskFinished.
absl::Status Replay(const std::map<int64_t, TaskRecord>& records, ActiveJob& active) {
  std::vector<Task> ready = active.plan->TakeReadyTasks();
  while (!ready.empty()) {
    for (Task& task : ready) {
      const auto record = records.find(task.number);
      if (record == records.end() || !record->second.result) {
        active.open_tasks.emplace(task.number, std::move(task));
        continue;
      }
      active.done_tasks.insert(task.number);
      COHORT_RETURN_IF_ERROR(active.plan->TaskFinished(task.number, *record->second.result));
    }
    ready = active.plan->TakeReadyTasks();
  }
  return absl::OkStatus();
}

TaskRecord RecordOf(int64_t number, const TaskAttempts& attempts) {
  TaskRecord record;
  record.number = number;
  record.epoch = attempts.epoch;
  record.failures = attempts.failures;
  record.losses = attempts.losses;
  return record;
}

}  // namespace

absl::Status Coordinator::Recover() {
  COHORT_ASSIGN_OR_RETURN(const std::vector<Job> jobs, catalog_.UnfinishedJobs());
  MutexLock lock(mutex_);
  for (const Job& job : jobs) {
    COHORT_RETURN_IF_ERROR(RecoverJob(job));
  }
  TakeChanges();  // Nobody listens yet.
  return absl::OkStatus();
}

absl::Status Coordinator::RecoverJob(const Job& job) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> job_meshes, catalog_.GetJobMeshes(job.id));
  std::vector<SetMesh> meshes;
  meshes.reserve(job_meshes.size());
  for (const JobMesh& mesh : job_meshes) {
    meshes.push_back(mesh.mesh);
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<TaskRecord> records, catalog_.LoadTasks(job.id));
  std::map<int64_t, TaskRecord> by_number;
  for (const TaskRecord& record : records) {
    by_number[record.number] = record;
  }
  ActiveJob& active = active_[job.id];
  active.job = job;
  COHORT_ASSIGN_OR_RETURN(active.plan, JobPlan::Create(job.spec, meshes, {}));
  const absl::Status verdict = Replay(by_number, active);
  if (!verdict.ok()) {
    return EndJob(active, JobState::kFailed, std::string(verdict.message()));
  }
  for (const auto& [number, task] : active.open_tasks) {
    const TaskId id{.job = job.id, .number = number};
    const TaskRecord& record = by_number[number];  // Empty if the task was never granted.
    const TaskAttempts attempts{
        .epoch = record.epoch, .failures = record.failures, .losses = record.losses};
    if (record.worker.empty()) {
      scheduler_.AddTask(id, attempts);
    } else {
      scheduler_.RestoreLease(id, attempts, WorkerId{record.worker}, clock_.Now());
    }
  }
  Touch(active);
  return Advance(active);
}

absl::Status Coordinator::Advance(ActiveJob& active) {
  std::vector<Task> ready = active.plan->TakeReadyTasks();
  while (!ready.empty()) {
    for (Task& task : ready) {
      absl::StatusOr<bool> known = FinishFromKnown(active, task);
      if (!known.ok() && known.status().code() == absl::StatusCode::kFailedPrecondition) {
        return EndJob(active, JobState::kFailed, std::string(known.status().message()));
      }
      COHORT_RETURN_IF_ERROR(known.status());
      if (!*known) {
        scheduler_.AddTask({.job = active.job.id, .number = task.number});
        active.open_tasks.emplace(task.number, std::move(task));
      }
    }
    ready = active.plan->TakeReadyTasks();
  }
  return active.plan->Done() ? EndJob(active, JobState::kSucceeded, "") : absl::OkStatus();
}

absl::StatusOr<bool> Coordinator::FinishFromKnown(ActiveJob& active, const Task& task) {
  if (task.kind != TaskKind::kIngest) {
    return false;
  }
  TaskResult result;
  for (const TaskMesh& mesh : task.meshes) {
    COHORT_ASSIGN_OR_RETURN(std::optional<IngestedMesh> known,
                            catalog_.FindIngested(mesh.blob, task.position_bits));
    if (!known) {
      return false;
    }
    COHORT_ASSIGN_OR_RETURN(const bool exists, store_.Contains(known->blob));
    if (!exists) {
      return false;
    }
    known->index = mesh.index;
    result.ingested.push_back(*std::move(known));
  }
  TaskRecord record = RecordOf(task.number, {});
  record.result = result;
  COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(active.job.id, {record}));
  active.done_tasks.insert(task.number);
  const absl::Status verdict = active.plan->TaskFinished(task.number, result);
  Touch(active);
  if (!verdict.ok()) {
    return verdict;
  }
  return true;
}

absl::Status Coordinator::GiveUpTasks(const std::vector<TaskId>& tasks) {
  for (const TaskId& task : tasks) {
    const auto found = active_.find(task.job);
    if (found != active_.end() && !IsFinal(found->second.job.state)) {
      COHORT_RETURN_IF_ERROR(EndJob(found->second, JobState::kFailed,
                                    "task " + std::to_string(task.number) +
                                        " was lost with too many workers; see "
                                        "their logs (out of memory?)"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<WorkerOrders> Coordinator::Synchronize(const WorkerReport& report,
                                                      const std::function<bool()>& is_cancelled) {
  if (report.build != options_.build) {
    return WithReason(
        absl::FailedPreconditionError("worker " + report.worker.value + " is build " +
                                      report.build + ", this server is build " + options_.build +
                                      ": install the same version on both"),
        "BUILD_MISMATCH");
  }
  WorkerOrders orders;
  orders.lease_seconds = options_.scheduler.lease_seconds;
  orders.next_sync_seconds = options_.scheduler.lease_seconds / 6;
  const MonotonicTime deadline =
      clock_.Now() + std::chrono::milliseconds(static_cast<int64_t>(report.wait_seconds * 1000));
  std::vector<Job> changes;
  {
    MutexLock lock(mutex_);
    while (true) {
      const MonotonicTime now = clock_.Now();
      orders.lost = scheduler_.Renew(report.worker, report.held, now);
      COHORT_RETURN_IF_ERROR(GiveUpTasks(scheduler_.Expire(now)));
      if (is_cancelled()) {
        return absl::CancelledError("worker " + report.worker.value + " has gone");
      }
      if (!stopping_ && !report.draining) {
        COHORT_ASSIGN_OR_RETURN(orders.grants, GrantTasks(report));
      }
      const bool wants_work = report.free_slots > 0 && orders.grants.empty();
      if (!wants_work || stopping_ || !orders.lost.empty() || now >= deadline) {
        break;
      }
      work_.WaitUntil(mutex_, std::min(deadline, now + kWaitStep));
    }
    changes = TakeChanges();
  }
  Notify(changes);
  return orders;
}

absl::StatusOr<std::vector<GrantedTask>> Coordinator::GrantTasks(const WorkerReport& report) {
  // Near the end of a stage a task held ready by one worker is missing to another.
  const bool plenty = scheduler_.ReadyCount() - report.free_slots > scheduler_.LeasedCount();
  const int count = report.free_slots + (plenty ? report.spare_slots : 0);
  const std::vector<Lease> leases = scheduler_.Grant(report.worker, count, clock_.Now());
  std::vector<GrantedTask> grants;
  grants.reserve(leases.size());
  std::map<JobId, std::vector<TaskRecord>> records;
  for (const Lease& lease : leases) {
    ActiveJob& active = active_.at(lease.task.job);
    grants.push_back({.lease = lease, .task = active.open_tasks.at(lease.task.number)});
    TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
    record.worker = report.worker.value;
    records[lease.task.job].push_back(record);
    NoteStage(grants.back().task.stage, active.job);
    if (active.job.state == JobState::kQueued) {
      active.job.state = JobState::kRunning;
      active.job.started_unix_ms = WallMs();
      Touch(active);
    }
  }
  for (const auto& [job, tasks] : records) {
    absl::Status saved = catalog_.SaveTasks(job, tasks);
    if (saved.ok()) {
      saved = catalog_.UpdateJob(active_.at(job).job);
    }
    if (!saved.ok()) {
      for (const Lease& lease : leases) {
        scheduler_.Release(lease, clock_.Now());
      }
      return saved;
    }
  }
  return grants;
}

absl::Status Coordinator::CheckOutputs(const TaskResult& result) {
  std::vector<Digest> outputs = {result.output, result.second_output, result.placed, result.fields};
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

absl::StatusOr<bool> Coordinator::CompleteTask(const WorkerId& worker,
                                               const Lease& lease,
                                               const TaskResult& result) {
  COHORT_RETURN_IF_ERROR(CheckOutputs(result));
  std::vector<Job> changes;
  {
    MutexLock lock(mutex_);
    const auto found = active_.find(lease.task.job);
    if (found == active_.end()) {
      return false;
    }
    ActiveJob& active = found->second;
    const auto open = active.open_tasks.find(lease.task.number);
    if (open == active.open_tasks.end()) {
      return false;
    }
    TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
    record.result = result;
    record.worker = worker.value;
    std::vector<std::pair<Digest, IngestedMesh>> ingested;
    for (const IngestedMesh& mesh : result.ingested) {
      const auto input = std::find_if(open->second.meshes.begin(), open->second.meshes.end(),
                                      [&](const TaskMesh& m) { return m.index == mesh.index; });
      if (input != open->second.meshes.end()) {
        ingested.emplace_back(input->blob, mesh);
      }
    }
    NoteStage(open->second.stage, active.job);
    Job next = active.job;
    ++next.version;
    const Completion completion = {
        .job = next, .task = std::move(record), .ingested = std::move(ingested), .action_key = ""};
    COHORT_RETURN_IF_ERROR(catalog_.SaveCompletions({&completion, 1}, WallMs()));
    // On disk: from here on memory follows, and nothing below can undo it.
    scheduler_.Complete(lease);
    active.open_tasks.erase(open);
    active.done_tasks.insert(lease.task.number);
    const absl::Status verdict = active.plan->TaskFinished(lease.task.number, result);
    Touch(active);
    if (!verdict.ok()) {
      COHORT_RETURN_IF_ERROR(EndJob(active, JobState::kFailed, std::string(verdict.message())));
    } else {
      COHORT_RETURN_IF_ERROR(Advance(active));
    }
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return true;
}

absl::Status Coordinator::ReleaseTask(const WorkerId& worker, const Lease& lease) {
  {
    MutexLock lock(mutex_);
    if (!scheduler_.Release(lease, clock_.Now())) {
      return absl::OkStatus();
    }
    TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
    record.last_error = "released by " + worker.value;
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(lease.task.job, {record}));
  }
  work_.NotifyAll();
  return absl::OkStatus();
}

absl::Status Coordinator::FailTask(const WorkerId& worker,
                                   const Lease& lease,
                                   const absl::Status& failure) {
  std::vector<Job> changes;
  {
    MutexLock lock(mutex_);
    const auto found = active_.find(lease.task.job);
    if (found == active_.end() || scheduler_.LeaseOf(lease.task) != lease) {
      return absl::OkStatus();  // Cancelled, or another worker has the task by now.
    }
    const bool given_up = scheduler_.Fail(lease, IsRetryable(failure.code()), clock_.Now());
    TaskRecord record = RecordOf(lease.task.number, scheduler_.AttemptsOf(lease.task));
    record.last_error = worker.value + ": " + std::string(failure.message());
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(lease.task.job, {record}));
    if (given_up) {
      const auto open = found->second.open_tasks.find(lease.task.number);
      const std::string stage =
          open == found->second.open_tasks.end() ? "" : " (" + open->second.stage + ")";
      COHORT_RETURN_IF_ERROR(EndJob(found->second, JobState::kFailed,
                                    "task " + std::to_string(lease.task.number) + stage + ": " +
                                        std::string(failure.message())));
    }
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return absl::OkStatus();
}

}  // namespace cohort
