#include "worker/tasks/task_context.h"

#include <string>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"

namespace cohort {

absl::Status TaskContext::CheckStop() const {
  ++ticks;
  return stop.stop_requested() ? absl::CancelledError("the worker was asked to stop")
                               : absl::OkStatus();
}

absl::Status WriteBlobs(const TaskContext& context, std::span<const TaskBlob> blobs) {
  context.EndComputing();
  std::vector<std::string_view> written;
  for (const TaskBlob& blob : blobs) {
    if (!blob.bytes.empty()) {
      written.push_back(blob.bytes);
    }
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<Digest> digests, context.store.PutAll(written));
  auto digest = digests.begin();
  for (const TaskBlob& blob : blobs) {
    if (!blob.bytes.empty()) {
      blob.digest = *digest++;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::map<int32_t, Alignment>> AlignmentsIn(std::string_view bytes) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> decoded, DecodeAlignmentBlob(bytes));
  std::map<int32_t, Alignment> alignments;
  for (const MeshAlignment& one : decoded) {
    alignments[one.mesh] = one.alignment;
  }
  return alignments;
}

absl::StatusOr<std::map<int32_t, Alignment>> LoadAlignments(BlobStore& store,
                                                            const std::vector<Digest>& blobs) {
  std::map<int32_t, Alignment> alignments;
  for (const Digest& blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(const auto some, AlignmentsIn(bytes));
    for (const auto& [mesh, alignment] : some) {
      alignments[mesh] = alignment;
    }
  }
  return alignments;
}

absl::StatusOr<Similarity> SimilarityOf(const std::map<int32_t, Alignment>& alignments,
                                        const TaskMesh& mesh) {
  if (alignments.empty()) {
    return Similarity{};
  }
  const auto found = alignments.find(mesh.index);
  if (found == alignments.end()) {
    return absl::DataLossError("mesh " + mesh.name + ": its alignment is not in the task's inputs");
  }
  return found->second.T_target_source;
}

}  // namespace cohort
