#include "client/job_frame.h"

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

absl::StatusOr<TriangleMesh> FetchMesh(BlobStore& blobs, const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, blobs.Get(digest));
  return DecodeMeshBlob(bytes);
}

}  // namespace

absl::StatusOr<std::unique_ptr<JobFrame>> JobFrame::Open(Session& session,
                                                         BlobStore& blobs,
                                                         const JobId& id) {
  std::unique_ptr<JobFrame> frame(new JobFrame);
  frame->blobs_ = &blobs;
  COHORT_ASSIGN_OR_RETURN(frame->job_, session.GetJob(id));
  if (frame->job_.state != JobState::kSucceeded) {
    return absl::FailedPreconditionError(absl::StrCat("job ", id.value, " is ",
                                                      std::string(JobStateName(frame->job_.state)),
                                                      ": it has no results to work with"));
  }
  COHORT_ASSIGN_OR_RETURN(frame->meshes_, session.ListJobMeshes(id));
  COHORT_ASSIGN_OR_RETURN(frame->outputs_, session.GetOutputs(id));
  COHORT_RETURN_IF_ERROR(frame->LoadAlignments());
  for (size_t i = 0; i < frame->meshes_.size(); ++i) {
    const JobMesh& mesh = frame->meshes_[i];
    if (!mesh.rejection.empty()) {
      continue;
    }
    const auto index = static_cast<int32_t>(i);
    if (!mesh.ingested || (frame->CheckHasFrame().ok() && !frame->T_frame_mesh_.contains(index))) {
      return absl::DataLossError(absl::StrCat("job ", id.value, ": mesh ", mesh.mesh.name,
                                              " has no alignment in the server's results"));
    }
    frame->active_.push_back(index);
  }
  return frame;
}

absl::Status JobFrame::LoadAlignments() {
  for (const Digest& blob : outputs_.alignments) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, blobs_->Get(blob));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> some, DecodeAlignmentBlob(bytes));
    for (const MeshAlignment& mesh : some) {
      T_frame_mesh_[mesh.mesh] = mesh.alignment.T_target_source;
    }
  }
  if (job_.spec.method == Method::kNone) {
    for (size_t i = 0; i < meshes_.size(); ++i) {
      T_frame_mesh_[static_cast<int32_t>(i)] = Similarity{};
    }
  }
  return absl::OkStatus();
}

absl::Status JobFrame::CheckHasFrame() const {
  if (job_.spec.arithmetic == Arithmetic::kFidentis) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job_.id.value,
                     " has the predecessor's numbers (preset fidentis), which are not found again "
                     "here"));
  }
  if (job_.spec.method == Method::kEach) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job_.id.value,
                     " aligned each pair by itself (method each): its meshes have no common "
                     "frame"));
  }
  return absl::OkStatus();
}

absl::StatusOr<int32_t> JobFrame::IndexOf(const std::string& name) const {
  const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                  [&](const JobMesh& mesh) { return mesh.mesh.name == name; });
  if (found == meshes_.end()) {
    return absl::NotFoundError(absl::StrCat("job ", job_.id.value, " has no mesh \"", name,
                                            "\"; it has ", meshes_.size(), ", the first is \"",
                                            meshes_.front().mesh.name, "\""));
  }
  if (!found->rejection.empty()) {
    return absl::FailedPreconditionError(absl::StrCat("mesh ", name, " of job ", job_.id.value,
                                                      " was rejected: ", found->rejection));
  }
  return static_cast<int32_t>(found - meshes_.begin());
}

absl::StatusOr<FramedMesh> JobFrame::Load(int32_t index, const PairMeshOptions& options) const {
  COHORT_RETURN_IF_ERROR(CheckHasFrame());
  const JobMesh& entry = meshes_[static_cast<size_t>(index)];
  const Digest& blob = entry.copy ? entry.copy->blob : entry.ingested->blob;
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, FetchMesh(*blobs_, blob));
  const Similarity T_frame_mesh = T_frame_mesh_.at(index);
  absl::StatusOr<PairMesh> placed = MakePairMesh(mesh, T_frame_mesh, Center(), options);
  if (!placed.ok()) {
    return absl::Status(placed.status().code(),
                        entry.mesh.name + ": " + std::string(placed.status().message()));
  }
  return FramedMesh{std::move(mesh), T_frame_mesh, *std::move(placed)};
}

absl::StatusOr<std::vector<FramedMesh>> JobFrame::LoadAll(const PairMeshOptions& options,
                                                          Executor& executor) const {
  std::vector<std::optional<FramedMesh>> loaded(active_.size());
  std::vector<absl::Status> statuses(active_.size());
  executor.ParallelFor(std::ssize(active_), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    absl::StatusOr<FramedMesh> mesh = Load(active_[place], options);
    statuses[place] = mesh.status();
    if (mesh.ok()) {
      loaded[place].emplace(*std::move(mesh));
    }
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  std::vector<FramedMesh> meshes;
  meshes.reserve(loaded.size());
  for (std::optional<FramedMesh>& mesh : loaded) {
    meshes.push_back(*std::move(mesh));
  }
  return meshes;
}

absl::StatusOr<TriangleMesh> JobFrame::LoadReference() const {
  COHORT_RETURN_IF_ERROR(CheckHasFrame());
  if (outputs_.frame.reference.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("job ", job_.id.value, " aligned nothing (method ",
                     std::string(MethodName(job_.spec.method)), "): it has no reference"));
  }
  return FetchMesh(*blobs_, outputs_.frame.reference);
}

absl::StatusOr<TriangleMesh> JobFrame::LoadMeanShape() const {
  return FetchMesh(*blobs_, outputs_.mean_shape);
}

absl::StatusOr<RegionMask> JobFrame::MakeRegion(std::vector<double> weights) const {
  COHORT_RETURN_IF_ERROR(CheckHasFrame());
  COHORT_ASSIGN_OR_RETURN(const TriangleMesh mean_shape, LoadMeanShape());
  return RegionMask{.reference = PackedMesh(PlaceVertices(mean_shape, Similarity{}, Center())),
                    .weights = std::move(weights)};
}

absl::Status FirstError(const std::vector<absl::Status>& statuses) {
  const auto failed = std::find_if(statuses.begin(), statuses.end(),
                                   [](const absl::Status& status) { return !status.ok(); });
  return failed == statuses.end() ? absl::OkStatus() : *failed;
}

int LocalThreads() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace cohort
