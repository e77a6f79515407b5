#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// A mesh as registration reads it: centred vertices in packets. Serves as source and as target.
/// Immutable after construction; const use may run together.
class IcpMesh {
 public:
  /// @param vertices  3 x n, n >= 1, mesh units.
  /// @param on_boundary  per vertex, 1 on the open boundary; empty: none is.
  explicit IcpMesh(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices,
                   std::vector<uint8_t> on_boundary = {});
  /// With its faces, for surface correspondences to it; a point cloud has none.
  [[nodiscard]] static IcpMesh WithSurface(const TriangleMesh& mesh,
                                           std::vector<uint8_t> on_boundary = {});

  /// Holds float(vertex - Center()).
  [[nodiscard]] const PackedMesh& Packed() const { return packed_; }
  [[nodiscard]] const Eigen::Vector3d& Center() const { return center_; }
  /// Null without faces.
  [[nodiscard]] const PackedSurface* Surface() const { return surface_.get(); }
  [[nodiscard]] bool HasBoundary() const { return !on_boundary_.empty(); }
  /// Only if HasBoundary().
  [[nodiscard]] bool IsOnBoundary(int32_t vertex) const {
    return on_boundary_[static_cast<size_t>(vertex)] != 0;
  }
  [[nodiscard]] bool IsSlotOnBoundary(int slot) const {
    return IsOnBoundary(packed_.VertexOfSlot()[static_cast<size_t>(slot)]);
  }

 private:
  Eigen::Vector3d center_;
  PackedMesh packed_;
  std::vector<uint8_t> on_boundary_;
  std::unique_ptr<const PackedSurface> surface_;
};

[[nodiscard]] PointTransform ToTransform(const Similarity& T);
/// The similarity between the packed vertices of two meshes.
[[nodiscard]] PointTransform PackedTransform(const Similarity& T_target_source,
                                             const IcpMesh& source,
                                             const IcpMesh& target);

}  // namespace cohort
