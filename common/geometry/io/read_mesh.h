#pragma once

#include <cstdint>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/file_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

enum class MeshFormat { kObj, kPly, kStl };

/// Sizes beyond which a file is refused before anything is allocated for it.
struct ReadLimits {
  int64_t max_bytes = int64_t{1} << 30;
  int64_t max_vertices = 20'000'000;
  int64_t max_faces = 40'000'000;
  /// @return kInvalidArgument if a limit is not positive or beyond what 32-bit indices can hold.
  [[nodiscard]] absl::Status Validate() const;
};

/// Format by content (magic words), then by the extension of `file_name`.
/// @return kInvalidArgument if neither tells.
[[nodiscard]] absl::StatusOr<MeshFormat> DetectMeshFormat(std::string_view bytes,
                                                          std::string_view file_name);

/// Parses an OBJ, PLY or STL file given as bytes.
///
/// Polygons are split into fans. Faces are as in the file otherwise: CheckAndClean comes after.
/// @param file_name  for the format and for messages only; nothing is opened.
/// @return kInvalidArgument with file, line (text) or byte offset (binary) and reason;
///         kResourceExhausted if a limit is exceeded.
[[nodiscard]] absl::StatusOr<TriangleMesh> ReadMesh(std::string_view bytes,
                                                    std::string_view file_name,
                                                    const ReadLimits& limits = {});

/// The same as float32, with the vertex normals of an OBJ file: vn i belongs to v i, as the
/// predecessor takes it. Fewer normals than vertices, or another format: none.
/// @return as ReadMesh; kInvalidArgument also for a vn line that is no three finite numbers.
[[nodiscard]] absl::StatusOr<FileMesh> ReadFileMesh(std::string_view bytes,
                                                    std::string_view file_name,
                                                    const ReadLimits& limits = {});

}  // namespace cohort
