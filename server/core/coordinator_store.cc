// What the coordinator does about its store: lost blobs, little space, garbage.
#include <algorithm>
#include <cmath>
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

/// A blob that is lost more often than this since the server started is not made again: the disk
/// does not keep what is written.
constexpr int kMostDamages = 3;

bool Names(const TaskResult& result, const Digest& blob) {
  const auto is_it = [&](const auto& item) { return item.blob == blob; };
  return result.output == blob || result.second_output == blob || result.placed == blob ||
         result.fields == blob ||
         std::any_of(result.ingested.begin(), result.ingested.end(), is_it) ||
         std::any_of(result.copies.begin(), result.copies.end(), is_it);
}

/// What came from people can only come from them again: why the job cannot go on, or empty.
std::string WhyOnlyPeopleHelp(const ActiveJob& active, const Digest& blob) {
  for (const JobMesh& mesh : active.plan->Meshes()) {
    if (mesh.mesh.raw == blob) {
      return absl::StrCat("the file of mesh ", mesh.mesh.name,
                          " is damaged or missing in the server's store (SHA-256 ", blob.Hex(),
                          "): add it again (cohort add --set ", active.job.set,
                          "), then cohort retry ", active.job.id.value);
    }
  }
  if (active.job.spec.landmarks == blob) {
    return absl::StrCat(
        "the landmarks of the job are damaged or missing in the server's store "
        "(SHA-256 ",
        blob.Hex(),
        "): submit the job again with the same landmark files; what is done is "
        "not done again");
  }
  return "";
}

}  // namespace

absl::StatusOr<bool> Coordinator::HandleDamagedBlob(const Lease& lease, const Digest& blob) {
  {
    const MutexLock lock(mutex_);
    if (!scheduler_.IsCurrent(lease)) {
      return true;  // Cancelled, given to another, or put back already.
    }
  }
  COHORT_ASSIGN_OR_RETURN(const bool is_lost, store_.QuarantineIfUnreadable(blob));
  if (!is_lost) {
    return false;
  }
  std::vector<Job> changes;
  bool is_seen_to = true;
  {
    const MutexLock lock(mutex_);
    const auto found = active_.find(lease.task.job);
    if (found == active_.end() || !scheduler_.IsCurrent(lease)) {
      return true;
    }
    ActiveJob& active = found->second;
    std::string why = WhyOnlyPeopleHelp(active, blob);
    if (why.empty() && ++times_damaged_[blob] > kMostDamages) {
      why = absl::StrCat("blob ", blob.Hex(), " was damaged ", kMostDamages + 1,
                         " times: check the disk of the server's store");
    }
    spdlog::error("event=blob_lost job={} task={} blob={} remedy=\"{}\"", lease.task.job.value,
                  lease.task.number, blob.Hex(), why.empty() ? "make it again" : why);
    if (why.empty()) {
      COHORT_ASSIGN_OR_RETURN(is_seen_to, MakeAgain(active, blob));
    } else {
      scheduler_.Fail(lease, false, clock_.Now());
      COHORT_RETURN_IF_ERROR(GiveUp({lease.task}, ": " + why));
    }
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return is_seen_to;
}

absl::StatusOr<bool> Coordinator::MakeAgain(ActiveJob& active, const Digest& blob) {
  std::vector<JobTask> lost;
  COHORT_RETURN_IF_ERROR(catalog_.VisitTasks(active.job.id, [&](const TaskRecord& record) {
    if (record.result && Names(*record.result, blob)) {
      lost.push_back({.job = active.job.id, .task = record});
      lost.back().task.result.reset();
      lost.back().task.worker.clear();
    }
    return absl::OkStatus();
  }));
  if (lost.empty()) {
    return false;
  }
  COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(lost, {}));
  // From here on as after a restart. What other tasks have done stays done.
  Job job = active.job;
  job.progress.tasks_reused = active.reused;
  for (const JobTask& task : lost) {
    job.progress.tasks_reused -= task.task.epoch == 0 ? 1 : 0;
  }
  TakeUpAgain(job);
  return true;
}

void Coordinator::TakeUpAgain(const Job& job) {
  scheduler_.RemoveJob(job.id);
  active_.erase(job.id);
  const absl::Status recovered = RecoverJob(job);
  if (recovered.ok()) {
    standing_.erase(job.id);
    return;
  }
  spdlog::error("event=job_stands job={} error=\"{}\"", job.id.value,
                std::string(recovered.message()));
  scheduler_.RemoveJob(job.id);
  active_.erase(job.id);
  standing_.insert(job.id);
}

absl::Status Coordinator::TakeUpStanding() {
  for (const JobId& id : std::set<JobId>(standing_)) {
    COHORT_ASSIGN_OR_RETURN(const Job job, catalog_.GetJob(id));
    if (IsFinal(job.state)) {
      standing_.erase(id);
    } else {
      TakeUpAgain(job);
    }
  }
  return absl::OkStatus();
}

absl::Status Coordinator::PutBack(ActiveJob& active, const std::vector<TaskRecord>& records) {
  if (records.empty()) {
    return absl::OkStatus();
  }
  std::vector<JobTask> tasks;
  tasks.reserve(records.size());
  for (const TaskRecord& record : records) {
    active.earlier_attempts[record.number] = {
        .epoch = record.epoch, .failures = record.failures, .losses = record.losses};
    active.reused -= record.epoch == 0 ? 1 : 0;
    tasks.push_back({.job = active.job.id, .task = record});
    tasks.back().task.worker.clear();
  }
  return catalog_.SaveTasks(tasks, {});
}

absl::Status Coordinator::ExplainDamage(const JobId& id, const absl::Status& read) {
  const std::optional<Digest> blob = UnreadableBlob(read);
  if (!blob) {
    return read;
  }
  COHORT_ASSIGN_OR_RETURN(const bool is_lost, store_.QuarantineIfUnreadable(*blob));
  if (!is_lost) {
    return absl::UnavailableError(
        absl::StrCat("blob ", blob->Hex(), " of job ", id.value, " could not be read; try again"));
  }
  spdlog::error("event=blob_lost job={} blob={} remedy=\"submit the job again\"", id.value,
                blob->Hex());
  return WithReason(
      WithUnreadableBlob(
          absl::DataLossError(absl::StrCat(
              "blob ", blob->Hex(), " of the results of job ", id.value,
              " is damaged or missing in the server's store: submit the job again with the same "
              "options; only what is lost is computed anew")),
          *blob),
      "BLOB_DAMAGED");
}

absl::Status Coordinator::CheckSpace() {
  COHORT_ASSIGN_OR_RETURN(const StoreSpace space, store_.Space());
  return options_.reserve.Check(space);
}

void Coordinator::NoteSpace(const absl::Status& space) {
  if (no_space_.empty() != space.ok()) {
    no_space_ = std::string(space.message());
    if (space.ok()) {
      spdlog::info("event=space_again");
    } else {
      spdlog::error("event=no_space error=\"{}\"", no_space_);
    }
  }
  for (auto& [id, active] : active_) {
    if (!IsFinal(active.job.state) && active.job.progress.waiting_for != no_space_) {
      active.job.progress.waiting_for = no_space_;
      Touch(active);
    }
  }
}

absl::StatusOr<GarbageCount> Coordinator::CollectGarbage(const GarbageOptions& options,
                                                         const std::stop_token& stop) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  {
    // Not while a job takes up a remembered result: until it is the job's own, only this row keeps
    // its blobs.
    const MutexLock lock(mutex_);
    const double before = static_cast<double>(WallMs()) - options.remember_seconds * 1000;
    COHORT_ASSIGN_OR_RETURN(const int64_t forgotten,
                            catalog_.ForgetActions(before > 0 ? static_cast<int64_t>(before) : 0));
    COHORT_ASSIGN_OR_RETURN(const int64_t forgotten_meshes, catalog_.ForgetUnusedIngested());
    spdlog::info("event=results_forgotten tasks={} meshes={}", forgotten, forgotten_meshes);
  }
  COHORT_ASSIGN_OR_RETURN(const GarbageCount count,
                          cohort::CollectGarbage(catalog_, store_, options.age_seconds, stop));
  spdlog::info("event=garbage_collected blobs={} bytes={} kept_blobs={} kept_bytes={}", count.blobs,
               count.bytes, count.kept_blobs, count.kept_bytes);
  return count;
}

}  // namespace cohort
