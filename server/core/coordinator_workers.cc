// What workers ask of the coordinator and tell it.
#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/jobs/action_key.h"
#include "common/store/blob_damage.h"
#include "server/core/coordinator.h"

namespace cohort {
namespace {

/// How often a waiting call looks whether leases have run out or its caller has gone.
constexpr std::chrono::milliseconds kWaitStep(250);
/// A worker without work that may not wait here calls again after this for each hundred workers.
constexpr double kIdleSecondsPerHundred = 0.5;
/// A worker silent for this many lease times is no longer listed.
constexpr double kListedLeaseTimes = 10;

bool IsRetryable(absl::StatusCode code) {
  // These fail in the same way anywhere: the input or the request is at fault.
  return code != absl::StatusCode::kInvalidArgument && code != absl::StatusCode::kDataLoss &&
         code != absl::StatusCode::kFailedPrecondition;
}

double SecondsBetween(MonotonicTime from, MonotonicTime to) {
  return std::chrono::duration<double>(to - from).count();
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

absl::StatusOr<WorkerOrders> Coordinator::Synchronize(const WorkerReport& report,
                                                      const std::function<bool()>& is_cancelled) {
  if (report.build != options_.build) {
    return WithReason(
        absl::FailedPreconditionError("worker " + report.worker.value + " is build " +
                                      report.build + ", this server is build " + options_.build +
                                      ": install the same version on both"),
        "BUILD_MISMATCH");
  }
  const MonotonicTime deadline =
      clock_.Now() + std::chrono::milliseconds(static_cast<int64_t>(report.wait_seconds * 1000));
  QueuedReport queued{.report = report, .is_cancelled = is_cancelled, .orders = {}, .status = {}};
  std::vector<Job> changes;
  const MonotonicTime called = clock_.Now();
  double waited_seconds = 0;  // For a task; not for the server.
  while (true) {
    queued.is_answered = false;
    {
      const MutexLock lock(queue_mutex_);
      reports_.push_back(&queued);
    }
    const MutexLock lock(mutex_);
    if (!queued.is_answered) {
      AnswerReports();
    }
    std::vector<Job> more = TakeChanges();
    changes.insert(changes.end(), more.begin(), more.end());
    const MonotonicTime now = clock_.Now();
    const bool wants_work = report.free_slots > 0 && !report.draining &&
                            queued.orders.grants.empty() && queued.orders.lost.empty();
    if (!queued.status.ok() || !wants_work || stopping_ || now >= deadline ||
        waiting_ >= options_.most_waiting) {
      queued.orders.next_sync_seconds = NextSyncSeconds(queued);
      break;
    }
    ++waiting_;
    work_.WaitUntil(mutex_, std::min(deadline, now + kWaitStep));
    --waiting_;
    waited_seconds += SecondsBetween(now, clock_.Now());
  }
  synchronize_timer_.Add(SecondsBetween(called, clock_.Now()) - waited_seconds);
  Notify(changes);
  COHORT_RETURN_IF_ERROR(queued.status);
  return queued.orders;
}

void Coordinator::AnswerReports() {
  std::vector<QueuedReport*> batch;
  {
    const MutexLock lock(queue_mutex_);
    batch.swap(reports_);
  }
  const MonotonicTime now = clock_.Now();
  std::vector<TaskId> given_up = scheduler_.Expire(now);
  GrantWrite write;
  for (QueuedReport* queued : batch) {
    queued->is_answered = true;
    queued->orders = {};
    queued->orders.lease_seconds = options_.scheduler.lease_seconds;
    NoteWorker(queued->report, now);
    Renewal renewal = scheduler_.Renew(queued->report.worker, queued->report.held, now);
    queued->orders.lost = std::move(renewal.lost);
    queued->orders.is_wedged = renewal.is_wedged;
    given_up.insert(given_up.end(), renewal.given_up.begin(), renewal.given_up.end());
    if (queued->is_cancelled()) {
      queued->status =
          absl::CancelledError(absl::StrCat("worker ", queued->report.worker.value, " has gone"));
      continue;
    }
    if (!stopping_ && no_space_.empty() && !queued->report.draining && !renewal.is_wedged) {
      for (const Lease& lease : GrantTasks(queued->report, now)) {
        AddGrant(lease, *queued, write);
      }
    }
  }
  NoteLost();
  NoteReady(now, std::ssize(write.tasks));
  absl::Status saved = GiveUp(given_up,
                              " was lost with too many workers; see their logs (out of "
                              "memory?)");
  if (saved.ok() && !write.tasks.empty()) {
    std::vector<Job> jobs;
    for (const JobId& id : write.jobs) {
      jobs.push_back(active_.at(id).job);
    }
    saved = catalog_.SaveTasks(write.tasks, jobs);
  }
  if (!saved.ok()) {
    for (QueuedReport* queued : batch) {
      for (const GrantedTask& granted : queued->orders.grants) {
        scheduler_.Release(granted.lease, now);
      }
      queued->status = saved;
    }
  }
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

std::vector<Lease> Coordinator::GrantTasks(const WorkerReport& report, MonotonicTime now) {
  // Near the end of a stage a task held ready by one worker is missing to another.
  const bool plenty = scheduler_.ReadyCount() - report.free_slots > scheduler_.LeasedCount();
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
  if (has_free_slots && waiting_ >= options_.most_waiting) {
    return std::min(kIdleSecondsPerHundred * static_cast<double>(workers_.size()) / 100,
                    options_.scheduler.lease_seconds / 6);
  }
  return has_free_slots ? 0 : options_.scheduler.lease_seconds / 6;
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

ActiveJob* Coordinator::FindOpen(const TaskId& task) {
  const auto found = active_.find(task.job);
  const bool is_open =
      found != active_.end() && !IsFinal(found->second.job.state) && scheduler_.IsOpen(task);
  return is_open ? &found->second : nullptr;
}

absl::StatusOr<bool> Coordinator::CompleteTask(const WorkerId& worker,
                                               const Lease& lease,
                                               const TaskResult& result) {
  const MonotonicTime called = clock_.Now();
  COHORT_RETURN_IF_ERROR(CheckOutputs(result));
  QueuedCompletion queued{
      .worker = worker, .lease = lease, .result = result, .outcome = std::nullopt};
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
  }
  work_.NotifyAll();
  Notify(changes);
  complete_timer_.Add(SecondsBetween(called, clock_.Now()));
  return *queued.outcome;
}

void Coordinator::TakeCompletions() {
  std::vector<QueuedCompletion*> batch;
  {
    const MutexLock lock(queue_mutex_);
    batch.swap(completions_);
  }
  std::vector<Completion> writes;
  std::vector<QueuedCompletion*> wanted;
  std::set<TaskId> seen;
  for (QueuedCompletion* queued : batch) {
    queued->outcome = false;
    if (FindOpen(queued->lease.task) == nullptr || !seen.insert(queued->lease.task).second) {
      ++totals_.tasks_superseded;
      spdlog::info("event=result_superseded job={} task={} epoch={} worker={}",
                   queued->lease.task.job.value, queued->lease.task.number, queued->lease.epoch,
                   queued->worker.value);
      continue;
    }
    absl::StatusOr<Completion> completion = CompletionOf(*queued);
    if (!completion.ok()) {
      queued->outcome = completion.status();
      continue;
    }
    writes.push_back(*std::move(completion));
    wanted.push_back(queued);
  }
  if (wanted.empty()) {
    return;
  }
  const absl::Status saved = catalog_.SaveCompletions(writes, WallMs());
  std::set<JobId> jobs;
  for (QueuedCompletion* queued : wanted) {
    if (!saved.ok()) {
      queued->outcome = saved;
      continue;
    }
    // On disk: from here on memory follows, and nothing below can undo it.
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
}

absl::StatusOr<Completion> Coordinator::CompletionOf(const QueuedCompletion& queued) {
  const int64_t number = queued.lease.task.number;
  ActiveJob& active = active_.at(queued.lease.task.job);
  COHORT_RETURN_IF_ERROR(active.plan->Check(number, queued.result));
  Completion completion;
  NoteStage(active.plan->StageOf(number), active.job);
  completion.job = active.job;
  ++completion.job.version;
  completion.task = RecordOf(number, scheduler_.AttemptsOf(queued.lease.task));
  completion.task.result = queued.result;
  completion.task.worker = queued.worker.value;
  const Task task = active.plan->MakeTask(number);
  if (task.kind != TaskKind::kIngest) {
    completion.action_key = ActionKey(task);
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

absl::Status Coordinator::Tick() {
  std::vector<Job> changes;
  absl::Status status;
  const absl::Status space = CheckSpace();
  {
    const MutexLock lock(mutex_);
    NoteSpace(space);
    status = TakeUpStanding();
    const MonotonicTime now = clock_.Now();
    status.Update(GiveUp(scheduler_.Expire(now),
                         " was lost with too many workers; see their logs (out of memory?)"));
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
