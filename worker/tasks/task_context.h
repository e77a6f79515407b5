#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>
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
  std::atomic<int64_t>& ticks;             ///< HeldTask::ticks.
  std::function<void()> on_computed = {};  ///< TaskHooks::on_computed.

  /// Says that the task gets on; asked between meshes and pairs.
  /// @return kCancelled once the worker wants the task to end.
  [[nodiscard]] absl::Status CheckStop() const;
  /// What is left is to write the outputs: the next task may compute meanwhile.
  void EndComputing() const {
    permit.Release();
    if (on_computed) {
      on_computed();
    }
  }
};

/// A blob that a task writes, and where its digest goes; empty: there is none.
struct TaskBlob {
  std::string_view bytes;
  Digest& digest;
};
/// Ends the computing of the task and writes its blobs, all together.
/// @return as BlobStore::PutAll.
[[nodiscard]] absl::Status WriteBlobs(const TaskContext& context, std::span<const TaskBlob> blobs);

/// The alignments in the bytes of an alignment blob, by mesh index.
[[nodiscard]] absl::StatusOr<std::map<int32_t, Alignment>> AlignmentsIn(std::string_view bytes);
/// The same of `blobs` together.
[[nodiscard]] absl::StatusOr<std::map<int32_t, Alignment>> LoadAlignments(
    BlobStore& store, const std::vector<Digest>& blobs);

/// The alignment of `mesh`; the identity if `alignments` is empty.
/// @return kDataLoss if it is missing.
[[nodiscard]] absl::StatusOr<Similarity> SimilarityOf(
    const std::map<int32_t, Alignment>& alignments, const TaskMesh& mesh);

}  // namespace cohort
