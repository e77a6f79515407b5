#pragma once

#include <cstdint>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// Where a mesh was put before ICP, and what it cost.
struct CoarsePose {
  Similarity T_target_source;  ///< Rigid.
  double score = 0;            ///< RMS of the winner on the sampled points, target units.
  int64_t lookups = 0;
};

/// Rigid start for ICP between meshes in any pose.
///
/// Candidates: the given pose with centroids brought together, and every proper rotation that maps
/// the principal axes of the source onto those of the target (24). Each is improved by a few rigid
/// ICP passes on a few hundred source points spread over the surface; the best go on with more
/// points; the lowest RMS wins, the earlier candidate on a tie. Deterministic.
/// @param target_mesh  the mesh behind `target`.
/// @return kFailedPrecondition if either has no extent.
/// Source: ours.
[[nodiscard]] absl::StatusOr<CoarsePose> FindCoarsePose(const TriangleMesh& source,
                                                        const TriangleMesh& target_mesh,
                                                        const IcpTarget& target);

}  // namespace cohort
