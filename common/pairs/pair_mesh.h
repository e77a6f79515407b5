#pragma once

#include <memory>

#include <absl/status/statusor.h>
#include <Eigen/Core>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/geometry/registration/similarity.h"
#include "common/jobs/job_spec.h"

namespace cohort {

/// The vertices T_frame_mesh * x - frame_center, as all distances of a job are measured: 3 x n.
[[nodiscard]] Eigen::Matrix3Xf PlaceVertices(const TriangleMesh& mesh,
                                             const Similarity& T_frame_mesh,
                                             const Eigen::Vector3d& frame_center);

/// What of a mesh is needed besides its vertices.
struct PairMeshOptions {
  CompareOptions compare;
  DistanceSign sign = DistanceSign::kAbsolute;  ///< kSigned: normals are kept.
};

/// A mesh in the common frame of a job, with all that measuring its pairs needs. Immutable.
struct PairMesh {
  PackedMesh vertices;
  std::unique_ptr<const IcpMesh> unplaced;       ///< BoundaryPairs::kReject: knows the boundary.
  std::unique_ptr<const PackedSurface> surface;  ///< Correspondence::kSurface.
  Eigen::Matrix3Xf slot_points;                  ///< kSigned: 3 x n, in slot order.
  Eigen::Matrix3Xf slot_normals;                 ///< kSigned: 3 x n, in slot order.
};

/// @return kFailedPrecondition for a point cloud where a surface or normals are needed.
[[nodiscard]] absl::StatusOr<PairMesh> MakePairMesh(const TriangleMesh& mesh,
                                                    const Similarity& T_frame_mesh,
                                                    const Eigen::Vector3d& frame_center,
                                                    const PairMeshOptions& options);

}  // namespace cohort
