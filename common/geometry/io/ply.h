#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Parses PLY 1.0, text or binary of either byte order: x, y, z of "vertex" (any number type) and
/// "vertex_indices" or "vertex_index" of "face". Other properties and elements are passed over.
/// A file without faces is a point cloud; triangle strips are refused.
/// @return as ReadMesh.
[[nodiscard]] absl::StatusOr<TriangleMesh> ReadPly(std::string_view bytes,
                                                   std::string_view file_name,
                                                   const ReadLimits& limits);

}  // namespace cohort
