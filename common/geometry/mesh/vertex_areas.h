#pragma once

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// The part of the surface that each vertex stands for: a third of the area of its faces; n values,
/// square mesh units, that add up to the area of the mesh. 0 for a vertex without a face, hence
/// for all of a point cloud.
[[nodiscard]] Eigen::VectorXd VertexAreas(const TriangleMesh& mesh);

}  // namespace cohort
