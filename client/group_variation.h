#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/job_frame.h"
#include "common/base/executor.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/scaling_icp.h"

namespace cohort {

/// The meshes of a job as seen from its mean shape.
struct CorrespondedSet {
  TriangleMesh mean_shape;
  Eigen::Matrix3Xd normals;        ///< Of the mean shape, unit or zero.
  std::vector<std::string> names;  ///< Active meshes.
  /// For each of them 3 x n: from each vertex of the mean shape to the mesh.
  std::vector<Eigen::Matrix3Xf> displacements;
};

/// From each of some vertices in a job's frame to the nearest vertex or point of the surface of a
/// mesh, as the job's rounds found them.
/// @param packed  of `vertices`.
/// @return 3 x n.
[[nodiscard]] Eigen::Matrix3Xd DisplacementsTo(const FramedMesh& mesh,
                                               const Eigen::Matrix3Xd& vertices,
                                               const IcpMesh& packed,
                                               Correspondence correspondence);

/// Finds all correspondences once more, as the job's rounds did (nearest vertices, or points of the
/// surface).
/// @return as JobFrame::Load; kFailedPrecondition for a point cloud.
[[nodiscard]] absl::StatusOr<CorrespondedSet> FindCorrespondences(const JobFrame& frame,
                                                                  Executor& executor);

/// What some meshes show at each vertex of the mean shape.
struct GroupVariation {
  std::string name;
  int64_t meshes = 0;
  std::vector<MetricValues> metrics;   ///< n: of the distances to the meshes of the group.
  std::vector<double> deviation;       ///< n: standard deviation of the signed distances.
  std::vector<double> signed_mean;     ///< n: + in front of the mean shape, mm.
  Eigen::Matrix3Xd mean_displacement;  ///< 3 x n.
};

/// @param members  positions in `set`, at least one.
[[nodiscard]] GroupVariation VariationOf(const CorrespondedSet& set,
                                         const std::string& name,
                                         const std::vector<size_t>& members,
                                         Executor& executor);

}  // namespace cohort
