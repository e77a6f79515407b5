#include "common/pairs/align_mesh.h"

#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/boundary.h"
#include "common/geometry/registration/coarse_pose.h"
#include "common/geometry/registration/undersampling.h"

namespace cohort {

absl::StatusOr<Alignment> AlignMeshTo(const TriangleMesh& mesh,
                                      const TriangleMesh& target,
                                      const JobSpec& spec) {
  const bool to_surface = spec.icp.correspondence == Correspondence::kSurface;
  if (to_surface && target.IsPointCloud()) {
    return absl::FailedPreconditionError(
        "what it is aligned to is a point cloud: correspondence surface needs faces");
  }
  Similarity start;
  if (spec.pose != PoseMode::kNone) {
    COHORT_ASSIGN_OR_RETURN(const CoarsePose pose, FindCoarsePose(mesh, target));
    start = pose.T_target_source;
  }
  const IcpMesh packed_target = to_surface ? IcpMesh::WithSurface(target, BoundaryVertices(target))
                                           : IcpMesh(target.vertices, BoundaryVertices(target));
  PacketSearch search;
  if (spec.undersampling.method == UndersamplingMethod::kNone) {
    return AlignByIcp(IcpMesh(mesh.vertices, BoundaryVertices(mesh)), packed_target, start,
                      spec.icp, search);
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<int32_t> kept,
                          SelectVertices(mesh, spec.undersampling));
  const Eigen::Matrix3Xd vertices = mesh.vertices(Eigen::all, kept);
  return AlignByIcp(IcpMesh(vertices), packed_target, start, spec.icp, search);
}

}  // namespace cohort
