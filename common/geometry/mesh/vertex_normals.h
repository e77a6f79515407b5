#pragma once

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Unit normal of each vertex: the mean of its faces' normals weighted by area, 3 x n.
/// A vertex without a face of positive area gets (0, 0, 0).
[[nodiscard]] Eigen::Matrix3Xd VertexNormals(const TriangleMesh& mesh);

}  // namespace cohort
