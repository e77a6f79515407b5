#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "common/geometry/registration/similarity.h"
#include "common/geometry/registration/surface_sample.h"

namespace cohort {

/// Where a mesh was put before ICP, and what it cost.
struct CoarsePose {
  Similarity T_target_source;  ///< Rigid.
  /// RMS of the winner on the sampled points of both meshes, without the farthest 15 %, target
  /// units.
  double score = 0;
  int64_t lookups = 0;  ///< Among sampled points only.
};

/// A mesh as coarse poses see it: how it lies, and points spread over its surface. Some 30 KB.
class PoseShape {
 public:
  /// @return kFailedPrecondition if the mesh has no extent.
  [[nodiscard]] static absl::StatusOr<PoseShape> Create(const TriangleMesh& mesh);

  [[nodiscard]] const PrincipalFrame& Frame() const { return frame_; }
  /// About the frame's centroid; one set for each round of the search, ever more points.
  [[nodiscard]] const std::vector<PackedMesh>& Samples() const { return samples_; }
  /// Memory held.
  [[nodiscard]] int64_t ByteCount() const;

 private:
  explicit PoseShape(PrincipalFrame frame) : frame_(std::move(frame)) {}

  PrincipalFrame frame_;
  std::vector<PackedMesh> samples_;
};

/// Rigid start for ICP between meshes in any pose.
///
/// Candidates, with centroids brought together: the given pose, the 24 proper rotations that map
/// the principal axes of the source onto those of the target, and 48 turns in between
/// (icosahedral). Each is improved by a few passes of rigid trimmed ICP, both ways, on points
/// spread over the two surfaces; the best different ones go on with more points; the lowest RMS
/// wins, the earlier candidate on a tie, and is improved until it rests. The given pose must be 5 %
/// better than the others, so that the result does not depend on it unless the shape cannot tell.
/// The cost does not depend on the sizes: some 180,000 look-ups among 100 to 600 points. The same
/// bytes on every path.
/// @return kFailedPrecondition if a fit fails.
/// Source: ours.
[[nodiscard]] absl::StatusOr<CoarsePose> FindCoarsePose(const PoseShape& source,
                                                        const PoseShape& target);

/// The same of two meshes.
/// @return also as PoseShape::Create.
[[nodiscard]] absl::StatusOr<CoarsePose> FindCoarsePose(const TriangleMesh& source,
                                                        const TriangleMesh& target);

}  // namespace cohort
