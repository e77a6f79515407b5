// What a restarted server goes on with.
#include <string>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "server/core/coordinator.h"

namespace cohort {

absl::Status Coordinator::Recover() {
  COHORT_ASSIGN_OR_RETURN(const std::vector<Job> jobs, catalog_.UnfinishedJobs());
  const MutexLock lock(mutex_);
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
  ActiveJob& active = active_[job.id];
  active.job = job;
  if (!job.spec.reference_job.empty()) {
    COHORT_ASSIGN_OR_RETURN(active.kept, catalog_.GetOutputs(job.id));
  }
  COHORT_ASSIGN_OR_RETURN(active.plan, JobPlan::Create(job.spec, meshes, {}, active.kept));
  ServeJob(active);
  if (job.plan_version != options_.plan_version ||
      job.results_version != options_.results_version) {
    if (!active.kept.frame.reference.empty() && job.results_version != options_.results_version) {
      return EndJob(active, JobState::kFailed,
                    "begun by another version of cohort-server, as its reference job " +
                        job.spec.reference_job +
                        " was: their distances cannot be mixed with ours; submit it without "
                        "--reference");
    }
    COHORT_RETURN_IF_ERROR(StartOver(active));
  }
  active.reused = active.job.progress.tasks_reused;
  // A task has a higher number than those it needs: in number order the plan can take all results.
  absl::Status verdict;
  std::vector<TaskRecord> begun;
  std::vector<TaskRecord> too_early;
  COHORT_RETURN_IF_ERROR(catalog_.VisitTasks(job.id, [&](const TaskRecord& record) {
    if (!record.result) {
      begun.push_back(record);
    } else if (verdict.ok()) {
      const absl::Status taken = active.plan->TaskFinished(record.number, *record.result);
      if (absl::IsNotFound(taken)) {
        too_early.push_back(record);
        too_early.back().result.reset();
      } else {
        verdict = taken;
      }
    }
    return absl::OkStatus();
  }));
  if (!verdict.ok()) {
    return EndJob(active, JobState::kFailed, std::string(verdict.message()));
  }
  COHORT_RETURN_IF_ERROR(PutBack(active, too_early));
  for (const TaskRange& range : active.plan->TakeReady()) {
    active.unlooked.InsertRange(range.first, range.count);
  }
  for (const TaskRecord& record : begun) {
    const TaskId id{.job = job.id, .number = record.number};
    const TaskAttempts attempts{
        .epoch = record.epoch, .failures = record.failures, .losses = record.losses};
    // What another version has done is under another number, if it is known at all.
    if (active.is_started_over || !active.unlooked.Contains(record.number)) {
      active.earlier_attempts[record.number] = attempts;
      continue;
    }
    active.unlooked.Erase(record.number);
    if (record.given_up) {
      active.given_up.emplace(record.number, record.last_error);
    } else if (record.worker.empty()) {
      scheduler_.AddTask(id, attempts);
    } else {
      scheduler_.RestoreLease(id, attempts, WorkerId{record.worker}, clock_.Now());
    }
  }
  Touch(active);
  return Advance(active);
}

absl::Status Coordinator::StartOver(ActiveJob& active) {
  spdlog::warn(
      "event=job_started_over job={} plan={}.{} ours={}.{} reason=\"begun by another version; what "
      "it shares with ours is taken from there\"",
      active.job.id.value, active.job.plan_version, active.job.results_version,
      options_.plan_version, options_.results_version);
  active.is_started_over = true;
  active.job.plan_version = options_.plan_version;
  active.job.results_version = options_.results_version;
  active.job.progress = active.plan->CurrentProgress();
  active.job.counters = {};
  ++active.job.version;
  return catalog_.StartOver(active.job);
}

}  // namespace cohort
