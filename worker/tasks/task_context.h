#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <stop_token>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/registration/scaling_icp.h"
#include "common/jobs/task.h"
#include "common/store/blob_store.h"
#include "worker/tasks/compute_slots.h"
#include "worker/tasks/mesh_cache.h"

namespace cohort {

/// What a task may use besides its own fields.
struct TaskContext {
  BlobStore& store;
  MeshCache& meshes;
  std::stop_token stop;
  ComputeSlots::Permit& permit;
  std::atomic<int64_t>& ticks;  ///< HeldTask::ticks.

  /// Says that the task gets on; asked between meshes and pairs.
  /// @return kCancelled once the worker wants the task to end.
  [[nodiscard]] absl::Status CheckStop() const;
  /// What is left is to write the outputs: the next task may compute meanwhile.
  void EndComputing() const { permit.Release(); }
};

/// The alignments in `blobs` by mesh index.
[[nodiscard]] absl::StatusOr<std::map<int32_t, Alignment>> LoadAlignments(
    BlobStore& store, const std::vector<Digest>& blobs);

/// The alignment of `mesh`; the identity if `alignments` is empty.
/// @return kDataLoss if it is missing.
[[nodiscard]] absl::StatusOr<Similarity> SimilarityOf(
    const std::map<int32_t, Alignment>& alignments, const TaskMesh& mesh);

}  // namespace cohort
