#include "server/core/coordinator.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/base/utf8.h"

namespace cohort {
namespace {

constexpr int kMaxNameLength = 255;
constexpr int kDefaultPageSize = 100;
constexpr int kMaxPageSize = 1000;
constexpr int kCatalogPageSize = 1000;

/// Names go into CSV, file systems and URLs: no separators, no control characters.
absl::Status CheckName(const std::string& name, const char* what) {
  const bool bad_characters = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '/' || c == '\\' || c == 0x7f;
  });
  if (!IsValidUtf8(name) || name.empty() || name.size() > kMaxNameLength || bad_characters) {
    return WithReason(
        absl::InvalidArgumentError(std::string(what) + " '" + PrintableUtf8(name.substr(0, 80)) +
                                   "': expected 1 to 255 bytes without '/', '\\' and control "
                                   "characters"),
        "BAD_NAME");
  }
  return absl::OkStatus();
}

absl::StatusOr<int> CheckPageSize(int page_size) {
  if (page_size < 0) {
    return absl::InvalidArgumentError("page_size " + std::to_string(page_size) +
                                      ": must not be < 0");
  }
  return page_size == 0 ? kDefaultPageSize : std::min(page_size, kMaxPageSize);
}

}  // namespace

Coordinator::Coordinator(const CoordinatorOptions& options,
                         Catalog& catalog,
                         ManagedBlobStore& store,
                         const Clock& clock)
    : options_(options),
      catalog_(catalog),
      store_(store),
      clock_(clock),
      scheduler_(options.scheduler) {}

absl::StatusOr<std::unique_ptr<Coordinator>> Coordinator::Create(const CoordinatorOptions& options,
                                                                 Catalog& catalog,
                                                                 ManagedBlobStore& store,
                                                                 const Clock& clock) {
  std::unique_ptr<Coordinator> coordinator(new Coordinator(options, catalog, store, clock));
  COHORT_RETURN_IF_ERROR(coordinator->Recover());
  return coordinator;
}

absl::StatusOr<SetMesh> Coordinator::AddMesh(const std::string& set, const SetMesh& mesh) {
  COHORT_RETURN_IF_ERROR(CheckName(set, "set"));
  COHORT_RETURN_IF_ERROR(CheckName(mesh.name, "mesh"));
  COHORT_ASSIGN_OR_RETURN(const bool exists, store_.Renew(mesh.raw));
  if (!exists) {
    return WithReason(absl::FailedPreconditionError("mesh " + mesh.name + ": the server has no " +
                                                    mesh.raw.Hex() + "; send the bytes"),
                      "BLOB_MISSING");
  }
  COHORT_RETURN_IF_ERROR(catalog_.AddMesh(set, mesh));
  return mesh;
}

absl::StatusOr<std::vector<Digest>> Coordinator::FindMissing(const std::vector<Digest>& digests) {
  std::vector<Digest> missing;
  for (const Digest& digest : digests) {
    COHORT_ASSIGN_OR_RETURN(const bool exists, store_.Renew(digest));
    if (!exists) {
      missing.push_back(digest);
    }
  }
  return missing;
}

absl::StatusOr<Page<SetMesh>> Coordinator::ListMeshes(const std::string& set,
                                                      int page_size,
                                                      const std::string& token) {
  COHORT_ASSIGN_OR_RETURN(const int size, CheckPageSize(page_size));
  return catalog_.ListMeshes(set, size, token);
}

absl::StatusOr<Page<MeshSet>> Coordinator::ListSets(int page_size, const std::string& token) {
  COHORT_ASSIGN_OR_RETURN(const int size, CheckPageSize(page_size));
  return catalog_.ListSets(size, token);
}

absl::Status Coordinator::RemoveMesh(const std::string& set, const std::string& name) {
  return catalog_.RemoveMesh(set, name);
}

absl::Status Coordinator::DeleteSet(const std::string& set) {
  return catalog_.DeleteSet(set);
}

absl::Status Coordinator::CheckLandmarks(const JobSpec& spec) {
  if (spec.landmarks.empty()) {
    return absl::OkStatus();
  }
  COHORT_ASSIGN_OR_RETURN(const bool exists, store_.Renew(spec.landmarks));
  return exists ? absl::OkStatus()
                : WithReason(absl::FailedPreconditionError("landmarks: the server has no " +
                                                           spec.landmarks.Hex() +
                                                           "; write the blob first"),
                             "BLOB_MISSING");
}

absl::StatusOr<Job> Coordinator::CreateJob(const std::string& set,
                                           const JobSpec& spec,
                                           const std::string& request_id) {
  COHORT_RETURN_IF_ERROR(spec.Validate());
  COHORT_RETURN_IF_ERROR(CheckSpace());
  COHORT_RETURN_IF_ERROR(CheckLandmarks(spec));
  COHORT_ASSIGN_OR_RETURN(const std::vector<SetMesh> meshes, AllMeshes(set));
  JobSpec complete = spec;
  JobOutputs kept;
  if (!spec.reference_job.empty()) {
    COHORT_ASSIGN_OR_RETURN(ReferenceFrame frame, FrameFor(spec, meshes));
    complete = std::move(frame.spec);
    kept = std::move(frame.kept);
  }
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<JobPlan> plan,
                          JobPlan::Create(complete, meshes, {}, kept));
  COHORT_RETURN_IF_ERROR(CheckRoom({.set = set, .spec = complete, .request_id = request_id}, meshes,
                                   kept, plan->Forecast()));

  Job wanted;
  wanted.set = set;
  wanted.spec = complete;
  wanted.version = 1;
  wanted.plan_version = options_.plan_version;
  wanted.results_version = options_.results_version;
  wanted.meshes = static_cast<int64_t>(meshes.size());
  wanted.progress = plan->CurrentProgress();
  Job created;
  std::vector<Job> changes;
  {
    const MutexLock lock(mutex_);
    COHORT_ASSIGN_OR_RETURN(created,
                            catalog_.CreateJob(wanted, meshes, request_id, WallMs(), kept));
    const auto running = active_.find(created.id);
    if (running != active_.end()) {
      return running->second.job;
    }
    if (IsFinal(created.state)) {
      return created;
    }
    ActiveJob& active = active_[created.id];
    active.job = created;
    active.plan = std::move(plan);
    active.kept = std::move(kept);
    ServeJob(active);
    COHORT_RETURN_IF_ERROR(Advance(active));
    created = active.job;
    changes = TakeChanges();
  }
  work_.NotifyAll();
  Notify(changes);
  return created;
}

absl::StatusOr<std::vector<SetMesh>> Coordinator::AllMeshes(const std::string& set) {
  std::vector<SetMesh> meshes;
  std::string token;
  do {
    COHORT_ASSIGN_OR_RETURN(Page<SetMesh> page, catalog_.ListMeshes(set, kCatalogPageSize, token));
    meshes.insert(meshes.end(), page.items.begin(), page.items.end());
    token = page.next_token;
  } while (!token.empty());
  return meshes;
}

absl::StatusOr<ReferenceFrame> Coordinator::FrameFor(const JobSpec& spec,
                                                     const std::vector<SetMesh>& meshes) {
  const JobId id{spec.reference_job};
  COHORT_ASSIGN_OR_RETURN(const Job reference, GetJob(id));
  if (reference.results_version != options_.results_version) {
    return WithReason(absl::FailedPreconditionError(
                          "reference job " + id.value +
                          " was computed by another version of cohort-server: its distances cannot "
                          "be mixed with ours; submit it again"),
                      "REFERENCE_UNUSABLE");
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> reference_meshes, GetJobMeshes(id));
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, catalog_.GetOutputs(id));
  absl::StatusOr<ReferenceFrame> frame =
      MakeReferenceFrame(reference, reference_meshes, outputs, spec, meshes, store_);
  if (!frame.ok()) {
    return ExplainDamage(id, frame.status());
  }
  return frame;
}

absl::StatusOr<Job> Coordinator::GetJob(const JobId& id) {
  {
    MutexLock lock(mutex_);
    const auto running = active_.find(id);
    if (running != active_.end()) {
      return running->second.job;
    }
  }
  return catalog_.GetJob(id);
}

absl::StatusOr<Page<Job>> Coordinator::ListJobs(int page_size, const std::string& token) {
  COHORT_ASSIGN_OR_RETURN(const int size, CheckPageSize(page_size));
  COHORT_ASSIGN_OR_RETURN(Page<Job> page, catalog_.ListJobs(size, token));
  MutexLock lock(mutex_);
  for (Job& job : page.items) {
    const auto running = active_.find(job.id);
    if (running != active_.end()) {
      job = running->second.job;
    }
  }
  return page;
}

absl::StatusOr<std::vector<JobMesh>> Coordinator::GetJobMeshes(const JobId& id) {
  {
    MutexLock lock(mutex_);
    const auto running = active_.find(id);
    if (running != active_.end()) {
      return running->second.plan->Meshes();
    }
  }
  return catalog_.GetJobMeshes(id);
}

absl::StatusOr<JobOutputs> Coordinator::GetOutputs(const JobId& id) {
  COHORT_ASSIGN_OR_RETURN(const Job job, GetJob(id));
  if (job.state != JobState::kSucceeded) {
    return WithReason(
        absl::FailedPreconditionError(
            "job " + id.value + " is " + std::string(JobStateName(job.state)) +
            (job.error.empty() ? "" : " (" + job.error + ")") + ": it has no results"),
        "JOB_NOT_FINISHED");
  }
  return catalog_.GetOutputs(id);
}

absl::Status Coordinator::GetMatrix(const JobId& id,
                                    Metric metric,
                                    const std::function<bool(const MatrixBlock&)>& consume) {
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, GetOutputs(id));
  return ExplainDamage(id, ForEachMatrixBlock(store_, outputs, metric, consume));
}

absl::Status Coordinator::GetPreview(const JobId& id,
                                     const std::function<bool(const PreviewBlock&)>& consume) {
  COHORT_ASSIGN_OR_RETURN(const Job job, GetJob(id));
  if (!job.spec.preview) {
    return WithReason(absl::FailedPreconditionError("job " + id.value +
                                                    " makes no preview: submit it with --preview"),
                      "JOB_HAS_NO_PREVIEW");
  }
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, OutputsSoFar(id));
  if (outputs.preview.empty()) {
    return WithReason(absl::FailedPreconditionError(
                          "job " + id.value + " is " + std::string(JobStateName(job.state)) +
                          " and has not come to its preview, which follows the alignments"),
                      "JOB_NOT_FINISHED");
  }
  return ExplainDamage(id, ForEachPreviewBlock(store_, outputs, consume));
}

absl::StatusOr<JobOutputs> Coordinator::OutputsSoFar(const JobId& id) {
  {
    const MutexLock lock(mutex_);
    const auto active = active_.find(id);
    if (active != active_.end()) {
      return active->second.plan->Outputs();
    }
  }
  return catalog_.GetOutputs(id);
}

void Coordinator::Notify(const std::vector<Job>& changes) {
  if (observer_ != nullptr) {
    for (const Job& job : changes) {
      observer_->OnJobChanged(job);
    }
  }
}

void Coordinator::Stop() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
  }
  work_.NotifyAll();
}

int64_t Coordinator::WallMs() const {
  return std::chrono::duration_cast<std::chrono::milliseconds>(clock_.WallNow().time_since_epoch())
      .count();
}

}  // namespace cohort
