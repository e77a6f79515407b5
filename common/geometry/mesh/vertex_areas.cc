#include "common/geometry/mesh/vertex_areas.h"

#include <cassert>

#include <Eigen/Geometry>

namespace cohort {

Eigen::VectorXd VertexAreas(const TriangleMesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.VertexCount());
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3i face = mesh.faces.col(f);
    assert(face.minCoeff() >= 0 && face.maxCoeff() < mesh.VertexCount());
    const Eigen::Vector3d a = mesh.vertices.col(face[0]);
    const Eigen::Vector3d b = mesh.vertices.col(face[1]);
    const Eigen::Vector3d c = mesh.vertices.col(face[2]);
    // The cross product is twice the area of the face, a third of which goes to each corner.
    const double share = (b - a).cross(c - a).norm() / 6;
    for (const int32_t vertex : face) {
      areas[vertex] += share;
    }
  }
  return areas;
}

}  // namespace cohort
