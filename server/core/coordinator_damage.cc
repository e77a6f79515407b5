// What the coordinator does about blobs that its store has lost.
#include <algorithm>
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
  return result.output == blob || result.second_output == blob || result.poses == blob ||
         result.variation == blob || result.placed == blob || result.fields == blob ||
         std::any_of(result.ingested.begin(), result.ingested.end(), is_it) ||
         std::any_of(result.copies.begin(), result.copies.end(), is_it);
}

/// Whether what is kept of a reference job has the blob.
bool Names(const JobOutputs& kept, const Digest& blob) {
  const auto has = [&](const std::vector<Digest>& blobs) {
    return std::find(blobs.begin(), blobs.end(), blob) != blobs.end();
  };
  return kept.frame.reference == blob || has(kept.alignments) ||
         std::any_of(kept.imported.begin(), kept.imported.end(), [&](const ImportedPairs& pairs) {
           return has(pairs.tiles) || has(pairs.fields);
         });
}

/// The blobs of a job's results that it has made itself.
std::vector<Digest> OwnBlobs(const JobOutputs& outputs) {
  std::vector<Digest> blobs = {outputs.mean_shape, outputs.summary, outputs.variation_shape,
                               outputs.base_choice, outputs.frame.reference};
  for (const auto* list : {&outputs.tiles, &outputs.alignments, &outputs.fields, &outputs.preview,
                           &outputs.poses, &outputs.signatures}) {
    blobs.insert(blobs.end(), list->begin(), list->end());
  }
  std::erase_if(blobs, [](const Digest& blob) { return blob.empty(); });
  return blobs;
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
      // The job may be gone from `active_` after this, or be another object.
      const bool is_kept = Names(active.kept, blob);
      const std::string reference = active.job.spec.reference_job;
      COHORT_ASSIGN_OR_RETURN(is_seen_to, MakeAgain(active, blob));
      if (!is_seen_to && is_kept) {
        why = absl::StrCat("blob ", blob.Hex(), ", kept of the reference job ", reference,
                           ", is lost: cohort retry ", reference, ", then cohort retry ",
                           lease.task.job.value);
      }
    }
    if (!why.empty()) {
      is_seen_to = true;
      scheduler_.Fail(lease, false, clock_.Now());
      COHORT_RETURN_IF_ERROR(GiveUp({lease.task}, ": " + why));
    }
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return is_seen_to;
}

absl::StatusOr<std::vector<JobTask>> Coordinator::ForgetResultsIn(const JobId& id,
                                                                  const std::vector<Digest>& lost) {
  std::vector<JobTask> tasks;
  COHORT_RETURN_IF_ERROR(catalog_.VisitTasks(id, [&](const TaskRecord& record) {
    const bool is_lost =
        record.result && std::any_of(lost.begin(), lost.end(), [&](const Digest& blob) {
          return Names(*record.result, blob);
        });
    if (is_lost) {
      tasks.push_back({.job = id, .task = record});
      tasks.back().task.result.reset();
      tasks.back().task.worker.clear();
    }
    return absl::OkStatus();
  }));
  if (!tasks.empty()) {
    COHORT_RETURN_IF_ERROR(catalog_.SaveTasks(tasks, {}));
  }
  return tasks;
}

absl::StatusOr<bool> Coordinator::MakeAgain(ActiveJob& active, const Digest& blob) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobTask> lost, ForgetResultsIn(active.job.id, {blob}));
  if (lost.empty()) {
    return false;
  }
  // From here on as after a restart. What other tasks have done stays done.
  Job job = active.job;
  job.progress.tasks_reused = active.reused;
  for (const JobTask& task : lost) {
    job.progress.tasks_reused -= task.task.epoch == 0 ? 1 : 0;
  }
  TakeUpAgain(job);
  return true;
}

absl::StatusOr<std::optional<Job>> Coordinator::MakeLostResults(const Job& job) {
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, catalog_.GetOutputs(job.id));
  std::vector<Digest> lost;
  for (const Digest& blob : OwnBlobs(outputs)) {
    COHORT_ASSIGN_OR_RETURN(const bool is_lost, store_.QuarantineIfUnreadable(blob));
    if (is_lost) {
      lost.push_back(blob);
    }
  }
  if (lost.empty()) {
    return std::nullopt;
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes, catalog_.GetJobMeshes(job.id));
  JobOutputs kept;
  if (!job.spec.reference_job.empty()) {
    std::vector<SetMesh> files;
    files.reserve(meshes.size());
    for (const JobMesh& mesh : meshes) {
      files.push_back(mesh.mesh);
    }
    COHORT_ASSIGN_OR_RETURN(ReferenceFrame frame, FrameFor(job.spec, files));
    kept = std::move(frame.kept);
  }
  Job again = job;
  again.state = JobState::kRunning;
  again.finished_unix_ms = 0;
  ++again.version;
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    const auto other = active_.find(job.id);  // Somebody else was faster.
    if (other != active_.end()) {
      return other->second.job;
    }
    COHORT_RETURN_IF_ERROR(ForgetResultsIn(job.id, lost).status());
    COHORT_RETURN_IF_ERROR(catalog_.FinishJob(again, kept, meshes));
    COHORT_RETURN_IF_ERROR(RecoverJob(again));
    again = active_.at(job.id).job;
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return again;
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
  COHORT_ASSIGN_OR_RETURN(const JobId maker, MakerOf(id, *blob));
  spdlog::error("event=blob_lost job={} blob={} remedy=\"retry {}\"", id.value, blob->Hex(),
                maker.value);
  return WithReason(
      WithUnreadableBlob(absl::DataLossError(absl::StrCat(
                             "blob ", blob->Hex(), " of the results of job ", id.value,
                             " is damaged or missing in the server's store: \"cohort retry ",
                             maker.value, "\" computes what is lost and nothing else")),
                         *blob),
      "BLOB_DAMAGED");
}

absl::StatusOr<JobId> Coordinator::MakerOf(const JobId& id, const Digest& blob) {
  JobId maker = id;
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const Job job, GetJob(maker));
    COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, OutputsSoFar(maker));
    const std::vector<Digest> own = OwnBlobs(outputs);
    if (std::find(own.begin(), own.end(), blob) != own.end() || job.spec.reference_job.empty()) {
      return maker;
    }
    maker = JobId{job.spec.reference_job};
  }
}

}  // namespace cohort
