#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Parses Wavefront OBJ: the statements v and f; all others are passed over.
///
/// A vertex has 3, 4, 6 or 7 numbers (position, weight, colour); a corner of a face is v, v/vt,
/// v//vn or v/vt/vn with indices from 1, or from -1 backwards.
/// @return as ReadMesh.
[[nodiscard]] absl::StatusOr<TriangleMesh> ReadObj(std::string_view bytes,
                                                   std::string_view file_name,
                                                   const ReadLimits& limits);

/// A mesh and the normals of its file: vn lines in their order, as many as there are, whatever the
/// faces say of them.
struct ObjWithNormals {
  TriangleMesh mesh;
  Eigen::Matrix3Xd normals;  ///< 3 x k.
};
/// The statements v, f and vn.
/// @return as ReadMesh.
[[nodiscard]] absl::StatusOr<ObjWithNormals> ReadObjWithNormals(std::string_view bytes,
                                                                std::string_view file_name,
                                                                const ReadLimits& limits);

}  // namespace cohort
