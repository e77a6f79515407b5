#pragma once

#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/draco_codec.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// A mesh at rest. Little-endian:
///   8 bytes  "COHMESH1"
///   uint8    encoding: 0 raw, 1 Draco
///   raw:     uint64 n, uint64 m, n x 3 float64 (x y z), m x 3 int32
///   Draco:   the rest is a Draco bitstream
/// Canonical meshes are Draco; shapes that were computed (mean shapes) are raw, so that a
/// computed coordinate never changes.
[[nodiscard]] std::string EncodeRawMeshBlob(const TriangleMesh& mesh);
/// @return as EncodeDraco.
[[nodiscard]] absl::StatusOr<std::string> EncodeDracoMeshBlob(const TriangleMesh& mesh,
                                                              const DracoOptions& options);
/// Reads either. @return kDataLoss if it is not such a blob or holds an index out of range.
[[nodiscard]] absl::StatusOr<TriangleMesh> DecodeMeshBlob(std::string_view bytes);

}  // namespace cohort
