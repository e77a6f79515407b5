#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Which vertices lie on the open boundary: those of an edge that exactly one face uses.
/// @return n flags, 1 or 0; all 0 for a closed surface and for a point cloud.
[[nodiscard]] std::vector<uint8_t> BoundaryVertices(const TriangleMesh& mesh);

}  // namespace cohort
