#pragma once

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/jobs/job_spec.h"

namespace cohort {

/// One mesh brought to another as the tasks of a job with these options do it: coarse pose by shape
/// (unless PoseMode::kNone; landmarks are not looked at), then scaling ICP of the vertices that
/// the undersampling keeps.
/// @return as FindCoarsePose, SelectVertices and AlignByIcp; kFailedPrecondition if `target` is a
///         point cloud where its surface is needed.
[[nodiscard]] absl::StatusOr<Alignment> AlignMeshTo(const TriangleMesh& mesh,
                                                    const TriangleMesh& target,
                                                    const JobSpec& spec);

}  // namespace cohort
