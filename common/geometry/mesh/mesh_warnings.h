#pragma once

#include <string>
#include <vector>

#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// What became of faces and vertices that no later step of ours can use.
enum class Mending { kRemoved, kKept };

/// What is unusual about a mesh, one line each, for people.
/// @param mesh    cleaned, at least one vertex.
/// @param health  its numbers; warnings in it are not looked at.
[[nodiscard]] std::vector<std::string> MeshWarnings(const TriangleMesh& mesh,
                                                    const MeshHealth& health,
                                                    Mending mending = Mending::kRemoved);

}  // namespace cohort
