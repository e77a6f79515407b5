#pragma once

#include <span>
#include <string>

#include <absl/status/statusor.h>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/report/color_map.h"

namespace cohort {

/// Colours for the distances of a pair: absolute ones from 0 to their 98th percentile, signed ones
/// as far to both sides as the 98th percentile of |distance|.
/// @param distances  mesh units; NaN: does not count.
[[nodiscard]] ColorScale DistanceScale(std::span<const float> distances, DistanceSign sign);

/// A mesh with, for each vertex, its distance to another mesh as scalar "distance" and as colour
/// (PLY). Vertices that do not count (NaN) are grey.
/// @param distances  n values.
/// @return kInvalidArgument if there are not n.
[[nodiscard]] absl::StatusOr<std::string> DistanceMapPly(const TriangleMesh& mesh,
                                                         std::span<const float> distances,
                                                         const ColorScale& scale);

}  // namespace cohort
