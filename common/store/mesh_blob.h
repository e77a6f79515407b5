#pragma once

#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/draco_codec.h"
#include "common/geometry/mesh/file_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// A mesh at rest. Little-endian:
///   8 bytes  "COHMESH1"
///   uint8    encoding: 0 raw, 1 Draco, 2 as in the file
///   raw:     uint64 n, uint64 m, n x 3 float64 (x y z), m x 3 int32
///   Draco:   the rest is a Draco bitstream
///   file:    uint64 n, uint64 m, uint64 k (normals: 0 or n), n x 3 float32, m x 3 int32,
///            k x 3 float32
/// Canonical meshes are Draco; shapes that were computed (mean shapes) are raw, so that a
/// computed coordinate never changes. Jobs with the predecessor's arithmetic keep their meshes as
/// in the file.
[[nodiscard]] std::string EncodeRawMeshBlob(const TriangleMesh& mesh);
/// @return as EncodeDraco.
[[nodiscard]] absl::StatusOr<std::string> EncodeDracoMeshBlob(const TriangleMesh& mesh,
                                                              const DracoOptions& options);
/// @param mesh  indices in range.
[[nodiscard]] std::string EncodeFileMeshBlob(const FileMesh& mesh);
/// Reads any; of a mesh as in the file, all but its normals. @return kDataLoss if it is not such a
/// blob or holds an index out of range.
[[nodiscard]] absl::StatusOr<TriangleMesh> DecodeMeshBlob(std::string_view bytes);
/// Does the blob hold a mesh as in the file?
[[nodiscard]] bool IsFileMeshBlob(std::string_view bytes);
/// @return kDataLoss if it does not, or holds an index out of range, a number that is not finite,
///         or no vertex.
[[nodiscard]] absl::StatusOr<FileMesh> DecodeFileMeshBlob(std::string_view bytes);

}  // namespace cohort
