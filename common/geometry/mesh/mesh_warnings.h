#pragma once

#include <string>
#include <vector>

#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// What is unusual about a mesh, one line each, for people.
/// @param mesh    cleaned, at least one vertex.
/// @param health  its numbers; warnings in it are not looked at.
[[nodiscard]] std::vector<std::string> MeshWarnings(const TriangleMesh& mesh,
                                                    const MeshHealth& health);

}  // namespace cohort
