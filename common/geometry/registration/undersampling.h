#pragma once

#include <cstdint>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

enum class UndersamplingMethod {
  kNone,       ///< All vertices.
  kRandom,     ///< Each vertex with the same chance.
  kDisk,       ///< No two closer to each other than a radius.
  kCurvature,  ///< Those with the largest maximum principal curvature.
};

struct UndersamplingOptions {
  UndersamplingMethod method = UndersamplingMethod::kNone;
  int64_t count = 0;   ///< Vertices kept (kRandom, kCurvature); all if there are no more. 0: share.
  double share = 0.1;  ///< Of all vertices, in (0, 1], rounded; used where count is 0.
  double radius = 0;   ///< kDisk: mesh units, > 0.
  uint64_t seed = 1;   ///< kRandom.
  [[nodiscard]] absl::Status Validate() const;
  friend bool operator==(const UndersamplingOptions&, const UndersamplingOptions&) = default;
};

/// Which vertices of a mesh take part in ICP, ascending.
///
/// kRandom: a partial Fisher-Yates shuffle, so none is drawn twice. kDisk: in vertex order, each
/// vertex is kept whose distance to all kept ones is at least the radius; along the edges of the
/// mesh (shortest path), in a point cloud straight. kCurvature: equal values go by lower index.
/// @return kInvalidArgument for bad options; kFailedPrecondition if fewer than 3 vertices would be
///         kept, which no fit can use, or for kCurvature on a point cloud.
/// Source: thesis section 4.4; predecessor c4, without its defects.
[[nodiscard]] absl::StatusOr<std::vector<int32_t>> SelectVertices(
    const TriangleMesh& mesh, const UndersamplingOptions& options);

}  // namespace cohort
