#include "common/geometry/registration/mirror.h"

#include <cassert>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/geometry/mesh/bounds.h"
#include "common/geometry/nearest/nearest_vertex.h"

namespace cohort {

TriangleMesh MirroredMesh(const TriangleMesh& mesh) {
  assert(mesh.VertexCount() >= 1);
  TriangleMesh mirrored = mesh;
  const double center = CentroidOf(mesh.vertices).x();
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    mirrored.vertices(0, v) = 2 * center - mesh.vertices(0, v);
  }
  mirrored.faces.row(1) = mesh.faces.row(2);
  mirrored.faces.row(2) = mesh.faces.row(1);
  return mirrored;
}

TriangleMesh SymmetrizedMesh(const TriangleMesh& mesh, const Similarity& T_mesh_mirrored) {
  const Eigen::Matrix3Xd mirrored = T_mesh_mirrored.Apply(MirroredMesh(mesh).vertices);
  // The search works in float32, about the centroid.
  const Eigen::Vector3d center = CentroidOf(mesh.vertices);
  const std::unique_ptr<const NearestVertex> index =
      NearestVertex::Build((mirrored.colwise() - center).cast<float>());
  std::vector<int32_t> nearest(static_cast<size_t>(mesh.VertexCount()));
  std::vector<float> squared_distances(nearest.size());
  index->Find((mesh.vertices.colwise() - center).cast<float>(), nearest, squared_distances);

  TriangleMesh symmetrized = mesh;
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    symmetrized.vertices.col(v) =
        0.5 * (mesh.vertices.col(v) + mirrored.col(nearest[static_cast<size_t>(v)]));
  }
  return symmetrized;
}

}  // namespace cohort
