#include "server/core/reference_frame.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "common/jobs/field_blob.h"

namespace cohort {
namespace {

constexpr int32_t kGone = -1;

absl::Status CheckUsable(const Job& reference, const JobOutputs& outputs) {
  const auto refuse = [&](const std::string& why) {
    return WithReason(
        absl::FailedPreconditionError(absl::StrCat("reference job ", reference.id.value, " ", why)),
        "REFERENCE_UNUSABLE");
  };
  if (reference.state != JobState::kSucceeded) {
    return refuse(absl::StrCat("is ", std::string(JobStateName(reference.state)),
                               ": only one that has succeeded can be added to"));
  }
  if (reference.spec.arithmetic == Arithmetic::kFidentis) {
    return refuse("has the preset fidentis, whose frame depends on all meshes");
  }
  if (reference.spec.method == Method::kEach) {
    return refuse("has the method each, which has no common frame");
  }
  if (reference.spec.symmetric_copies) {
    return refuse("works with symmetric copies, which cannot be added to yet");
  }
  if (reference.spec.pose == PoseMode::kLandmarks) {
    return refuse("has poses by landmarks, which cannot be added to yet");
  }
  if (outputs.frame.reference.empty()) {
    return refuse("was made by an earlier build that did not keep its frame; submit it again");
  }
  return absl::OkStatus();
}

/// The new index of each of the reference job's meshes.
std::vector<int32_t> NewIndices(const std::vector<JobMesh>& reference,
                                const std::vector<SetMesh>& meshes) {
  std::map<std::string, int32_t> index_of;
  for (size_t i = 0; i < meshes.size(); ++i) {
    index_of[meshes[i].name] = static_cast<int32_t>(i);
  }
  std::vector<int32_t> mesh_of(reference.size(), kGone);
  for (size_t i = 0; i < reference.size(); ++i) {
    const auto found = index_of.find(reference[i].mesh.name);
    if (reference[i].rejection.empty() && found != index_of.end() &&
        meshes[static_cast<size_t>(found->second)].raw == reference[i].mesh.raw) {
      mesh_of[i] = found->second;
    }
  }
  return mesh_of;
}

/// What the reference job has imported itself, and its own pairs.
std::vector<ImportedPairs> PairsUnder(const JobOutputs& outputs,
                                      const std::vector<int32_t>& mesh_of) {
  std::vector<ImportedPairs> imported = outputs.imported;
  for (ImportedPairs& pairs : imported) {
    for (int32_t& mesh : pairs.mesh_of) {
      mesh = mesh == kGone ? kGone : mesh_of[static_cast<size_t>(mesh)];
    }
  }
  imported.push_back({.tiles = outputs.tiles, .fields = outputs.fields, .mesh_of = mesh_of});
  return imported;
}

/// One blob of the kept alignments.
absl::StatusOr<std::vector<Digest>> AlignmentsUnder(const JobOutputs& outputs,
                                                    const std::vector<int32_t>& mesh_of,
                                                    BlobStore& store) {
  std::map<int32_t, MeshAlignment> kept;
  for (const Digest& digest : outputs.alignments) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(digest));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> alignments,
                            DecodeAlignmentBlob(bytes));
    for (MeshAlignment alignment : alignments) {
      alignment.mesh = mesh_of.at(static_cast<size_t>(alignment.mesh));
      if (alignment.mesh != kGone) {
        kept.insert_or_assign(alignment.mesh, alignment);
      }
    }
  }
  if (kept.empty()) {
    return std::vector<Digest>();  // The method none aligns nothing.
  }
  std::vector<MeshAlignment> all;
  all.reserve(kept.size());
  for (const auto& [mesh, alignment] : kept) {
    all.push_back(alignment);
  }
  COHORT_ASSIGN_OR_RETURN(const Digest blob, store.Put(EncodeAlignmentBlob(all)));
  return std::vector<Digest>{blob};
}

/// What was kept of the distances: a growing set must not change its mind.
absl::StatusOr<Retention> RetentionOf(const JobOutputs& outputs, BlobStore& store) {
  const std::vector<Digest>* fields = &outputs.fields;
  for (const ImportedPairs& pairs : outputs.imported) {
    fields = fields->empty() ? &pairs.fields : fields;
  }
  if (fields->empty()) {
    return Retention::kMetrics;
  }
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(fields->front()));
  COHORT_ASSIGN_OR_RETURN(const FieldBlob blob, DecodeFieldBlob(bytes));
  return blob.retention;
}

}  // namespace

absl::StatusOr<ReferenceFrame> MakeReferenceFrame(const Job& reference,
                                                  const std::vector<JobMesh>& reference_meshes,
                                                  const JobOutputs& outputs,
                                                  const JobSpec& wanted,
                                                  const std::vector<SetMesh>& meshes,
                                                  BlobStore& store) {
  COHORT_RETURN_IF_ERROR(CheckUsable(reference, outputs));
  const std::vector<int32_t> mesh_of = NewIndices(reference_meshes, meshes);
  ReferenceFrame frame;
  frame.kept.frame = outputs.frame;
  frame.kept.imported = PairsUnder(outputs, mesh_of);
  if (std::all_of(mesh_of.begin(), mesh_of.end(), [](int32_t mesh) { return mesh == kGone; })) {
    return absl::InvalidArgumentError(
        absl::StrCat("the set has no mesh of the reference job ", reference.id.value,
                     " (by name and bytes): submit it without --reference"));
  }
  COHORT_ASSIGN_OR_RETURN(frame.kept.alignments, AlignmentsUnder(outputs, mesh_of, store));
  frame.spec = reference.spec;
  frame.spec.reference_job = reference.id.value;
  COHORT_ASSIGN_OR_RETURN(frame.spec.compare.retention, RetentionOf(outputs, store));
  // The frame stands for the base, and the preview would have to be made of all meshes.
  frame.spec.base.clear();
  frame.spec.base_rule = BaseRule::kGiven;
  frame.spec.preview = false;
  frame.spec.metric = wanted.metric;
  frame.spec.symmetrization = wanted.symmetrization;
  frame.spec.neighbours = wanted.neighbours;
  frame.spec.priority = wanted.priority;
  frame.spec.fresh = wanted.fresh;
  return frame;
}

}  // namespace cohort
