#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// True if the length is exactly what a binary STL with this triangle count has. It says more than
/// the word "solid": many binary files begin with it.
[[nodiscard]] bool HasBinaryStlSize(std::string_view bytes);

/// Parses STL, text (any number of solids) or binary. Corners at exactly the same position become
/// one vertex; vertices are in the order in which they first appear.
/// @return as ReadMesh.
[[nodiscard]] absl::StatusOr<TriangleMesh> ReadStl(std::string_view bytes,
                                                   std::string_view file_name,
                                                   const ReadLimits& limits);

}  // namespace cohort
