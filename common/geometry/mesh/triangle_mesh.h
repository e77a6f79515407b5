#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace cohort {

using Matrix3Xi = Eigen::Matrix<int32_t, 3, Eigen::Dynamic>;

/// A surface (or, without faces, a point cloud).
///
/// Invariant after ingest: finite vertices, at least one vertex, every index in range, no face that
/// uses a vertex twice.
struct TriangleMesh {
  Eigen::Matrix3Xd vertices;  ///< 3 x n, column i is vertex i, file units (mm for faces).
  Matrix3Xi faces;  ///< 3 x m, 0-based, counter-clockwise seen from outside; m = 0: cloud.

  [[nodiscard]] int64_t VertexCount() const { return vertices.cols(); }
  [[nodiscard]] int64_t FaceCount() const { return faces.cols(); }
  [[nodiscard]] bool IsPointCloud() const { return faces.cols() == 0; }
};

}  // namespace cohort
