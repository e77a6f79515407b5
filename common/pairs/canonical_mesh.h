#pragma once

#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// A mesh file as all later steps see it: checked, cleaned, in the order and with the coordinates
/// that Draco gave it.
struct CanonicalMesh {
  std::string blob;   ///< Draco (mesh_blob.h).
  TriangleMesh mesh;  ///< What the blob decodes to.
  MeshHealth health;  ///< Of the file.
};

/// @param name  for the format and for messages.
/// @return as ReadMesh and CheckAndClean, naming the file: every error is the file's fault.
[[nodiscard]] absl::StatusOr<CanonicalMesh> MakeCanonical(std::string_view bytes,
                                                          const std::string& name,
                                                          int position_bits);

}  // namespace cohort
