#include "common/pairs/pair_mesh.h"

#include "common/geometry/mesh/boundary.h"
#include "common/geometry/mesh/vertex_normals.h"

namespace cohort {
namespace {

/// The columns in slot order.
Eigen::Matrix3Xf InSlotOrder(const Eigen::Matrix3Xf& columns, const PackedMesh& packed) {
  Eigen::Matrix3Xf ordered(3, columns.cols());
  for (Eigen::Index slot = 0; slot < columns.cols(); ++slot) {
    ordered.col(slot) = columns.col(packed.VertexOfSlot()[static_cast<size_t>(slot)]);
  }
  return ordered;
}

}  // namespace

Eigen::Matrix3Xf PlaceVertices(const TriangleMesh& mesh,
                               const Similarity& T_frame_mesh,
                               const Eigen::Vector3d& frame_center) {
  return (T_frame_mesh.Apply(mesh.vertices).colwise() - frame_center).cast<float>();
}

absl::StatusOr<PairMesh> MakePairMesh(const TriangleMesh& mesh,
                                      const Similarity& T_frame_mesh,
                                      const Eigen::Vector3d& frame_center,
                                      const PairMeshOptions& options) {
  const bool needs_surface = options.compare.correspondence == Correspondence::kSurface;
  const bool needs_normals = options.sign == DistanceSign::kSigned;
  if (mesh.IsPointCloud() && (needs_surface || needs_normals)) {
    return absl::FailedPreconditionError(
        needs_surface ? "it is a point cloud: distances to surfaces need faces"
                      : "it is a point cloud: signed distances need faces");
  }
  const Eigen::Matrix3Xf placed = PlaceVertices(mesh, T_frame_mesh, frame_center);
  PairMesh made{.vertices = PackedMesh(placed),
                .unplaced = nullptr,
                .surface = nullptr,
                .slot_points = {},
                .slot_normals = {}};
  if (options.compare.boundary_pairs == BoundaryPairs::kReject) {
    made.unplaced = std::make_unique<const IcpMesh>(mesh.vertices, BoundaryVertices(mesh));
  }
  if (needs_surface) {
    made.surface = std::make_unique<const PackedSurface>(placed, mesh.faces);
  }
  if (needs_normals) {
    const Eigen::Matrix3Xd normals = T_frame_mesh.rotation * VertexNormals(mesh);
    made.slot_points = InSlotOrder(placed, made.vertices);
    made.slot_normals = InSlotOrder(normals.cast<float>(), made.vertices);
  }
  return made;
}

}  // namespace cohort
