#pragma once

#include <cstdint>
#include <memory>

#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/nearest/surface_search.h"
#include "worker/tasks/task_context.h"

namespace cohort {

/// Displacements from the vertices of one reference to aligned meshes: to their nearest vertices,
/// or to the nearest points of their surfaces. Holds the memory that searches need: one per thread.
class DisplacementFinder {
 public:
  /// @return as MeshCache::Get.
  [[nodiscard]] static absl::StatusOr<DisplacementFinder> Create(const Digest& reference,
                                                                 Correspondence correspondence,
                                                                 const TaskContext& context);

  /// @return 3 x VertexCount(), reference units; as MeshCache::GetIcpTarget.
  [[nodiscard]] absl::StatusOr<Eigen::Matrix3Xd> Find(const Digest& mesh,
                                                      const Similarity& T_reference_mesh);
  [[nodiscard]] int64_t VertexCount() const { return reference_->VertexCount(); }

 private:
  DisplacementFinder(Correspondence correspondence, const TaskContext& context)
      : correspondence_(correspondence), meshes_(context.meshes) {}

  Correspondence correspondence_;
  MeshCache& meshes_;
  std::shared_ptr<const TriangleMesh> reference_;
  std::shared_ptr<const IcpMesh> queries_;
  PacketSearch search_;
  SurfaceSearch surface_search_;
};

}  // namespace cohort
