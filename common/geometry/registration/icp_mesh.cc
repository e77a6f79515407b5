#include "common/geometry/registration/icp_mesh.h"

#include <cassert>
#include <utility>

#include "common/geometry/mesh/bounds.h"

namespace cohort {

IcpMesh::IcpMesh(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices,
                 std::vector<uint8_t> on_boundary)
    : center_(CentroidOf(vertices)),
      packed_((vertices.colwise() - center_).cast<float>()),
      on_boundary_(std::move(on_boundary)) {
  assert(on_boundary_.empty() || on_boundary_.size() == static_cast<size_t>(vertices.cols()));
}

IcpMesh IcpMesh::WithSurface(const TriangleMesh& mesh, std::vector<uint8_t> on_boundary) {
  IcpMesh packed(mesh.vertices, std::move(on_boundary));
  if (!mesh.IsPointCloud()) {
    packed.surface_ = std::make_unique<const PackedSurface>(
        (mesh.vertices.colwise() - packed.center_).cast<float>(), mesh.faces);
  }
  return packed;
}

PointTransform ToTransform(const Similarity& T) {
  PointTransform transform{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      transform.rows[row][column] = T.scale * T.rotation(row, column);
    }
    transform.rows[row][3] = T.translation[row];
  }
  return transform;
}

PointTransform PackedTransform(const Similarity& T_target_source,
                               const IcpMesh& source,
                               const IcpMesh& target) {
  Similarity T = T_target_source;
  T.translation = T_target_source.ApplyToPoint(source.Center()) - target.Center();
  return ToTransform(T);
}

}  // namespace cohort
