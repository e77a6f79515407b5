#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// A mesh exactly as its file has it, in float32: nothing is removed, mended or put in another
/// order. What the predecessor's numbers are computed from.
struct FileMesh {
  Eigen::Matrix3Xf vertices;  ///< 3 x n, file units.
  Matrix3Xi faces;            ///< 3 x m, 0-based; may hold a vertex twice, or the same face twice.
  Eigen::Matrix3Xf normals;   ///< 3 x n, of any length, as in the file; or none.

  [[nodiscard]] int64_t VertexCount() const { return vertices.cols(); }
  [[nodiscard]] bool HasNormals() const { return normals.cols() > 0; }
};

}  // namespace cohort
