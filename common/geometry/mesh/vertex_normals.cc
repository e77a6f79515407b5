#include "common/geometry/mesh/vertex_normals.h"

#include <cassert>

#include <Eigen/Geometry>

namespace cohort {

Eigen::Matrix3Xd VertexNormals(const TriangleMesh& mesh) {
  Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, mesh.VertexCount());
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3i face = mesh.faces.col(f);
    assert(face.minCoeff() >= 0 && face.maxCoeff() < mesh.VertexCount());
    const Eigen::Vector3d a = mesh.vertices.col(face[0]);
    const Eigen::Vector3d b = mesh.vertices.col(face[1]);
    const Eigen::Vector3d c = mesh.vertices.col(face[2]);
    // The cross product is the unit normal times twice the area: the weight comes for free.
    const Eigen::Vector3d weighted_normal = (b - a).cross(c - a);
    for (const int32_t vertex : face) {
      normals.col(vertex) += weighted_normal;
    }
  }
  for (Eigen::Index v = 0; v < normals.cols(); ++v) {
    const double largest = normals.col(v).cwiseAbs().maxCoeff();
    if (largest > 0) {
      // Scaled first, so that the squares of a mesh in metres cannot underflow.
      normals.col(v) /= largest;
      normals.col(v).normalize();
    }
  }
  return normals;
}

}  // namespace cohort
