#pragma once

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// How a surface bends at each vertex, 1 / mesh unit. Positive where it is convex seen from outside
/// (a sphere of radius r with outward faces: both 1 / r).
struct VertexCurvatures {
  Eigen::VectorXd maximum;  ///< n, larger principal curvature.
  Eigen::VectorXd minimum;  ///< n, smaller principal curvature.

  [[nodiscard]] Eigen::VectorXd Mean() const { return 0.5 * (maximum + minimum); }
  [[nodiscard]] Eigen::VectorXd Gaussian() const { return maximum.cwiseProduct(minimum); }
};

/// Principal curvatures of the quadric z = c + d x + e y + a x^2 / 2 + b x y + f y^2 / 2 that fits
/// a vertex and its surroundings best (least squares, z along the vertex normal).
///
/// The surroundings are the vertices up to two edges away, and further rings until there are 12 (at
/// an open boundary, where they lie on one side only); no more than 64. Methods that work from the
/// normals of single faces were tried: on irregular triangles their error does not shrink with the
/// triangles. A vertex whose surroundings determine no quadric, one without a face of positive
/// area, and every vertex of a point cloud get 0.
/// Source: Cazals, Pouget 2005, "Estimating differential quantities using polynomial fitting of
/// osculating jets", degree 2.
[[nodiscard]] VertexCurvatures CurvaturesOf(const TriangleMesh& mesh);

}  // namespace cohort
