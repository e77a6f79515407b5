#include "client/group_variation.h"

#include <cmath>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/boundary.h"
#include "common/geometry/mesh/vertex_normals.h"
#include "common/geometry/registration/mean_shape.h"

namespace cohort {
Eigen::Matrix3Xd DisplacementsTo(const FramedMesh& mesh,
                                 const Eigen::Matrix3Xd& vertices,
                                 const IcpMesh& packed,
                                 Correspondence correspondence) {
  if (correspondence == Correspondence::kSurface) {
    SurfaceSearch search;
    const IcpMesh target = IcpMesh::WithSurface(mesh.mesh, BoundaryVertices(mesh.mesh));
    return DisplacementToSurface(vertices, packed, target, mesh.T_frame_mesh, search);
  }
  PacketSearch search;
  return DisplacementToMesh(vertices, packed, mesh.mesh.vertices, IcpMesh(mesh.mesh.vertices),
                            mesh.T_frame_mesh, search);
}

absl::StatusOr<CorrespondedSet> FindCorrespondences(const JobFrame& frame, Executor& executor) {
  CorrespondedSet set;
  COHORT_ASSIGN_OR_RETURN(set.mean_shape, frame.LoadMeanShape());
  if (set.mean_shape.IsPointCloud()) {
    return absl::FailedPreconditionError("the mean shape of job " + frame.GetJob().id.value +
                                         " is a point cloud: signs and pictures need faces");
  }
  set.normals = VertexNormals(set.mean_shape);
  const IcpMesh packed_mean(set.mean_shape.vertices);
  const Correspondence correspondence = frame.GetJob().spec.icp.correspondence;
  const std::vector<int32_t>& active = frame.Active();
  set.displacements.resize(active.size());
  std::vector<absl::Status> statuses(active.size());
  executor.ParallelFor(std::ssize(active), [&](int64_t i) {
    const auto place = static_cast<size_t>(i);
    const absl::StatusOr<FramedMesh> mesh = frame.Load(active[place], {});
    statuses[place] = mesh.status();
    if (mesh.ok()) {
      set.displacements[place] =
          DisplacementsTo(*mesh, set.mean_shape.vertices, packed_mean, correspondence)
              .cast<float>();
    }
  });
  COHORT_RETURN_IF_ERROR(FirstError(statuses));
  for (const int32_t index : active) {
    set.names.push_back(frame.Meshes()[static_cast<size_t>(index)].mesh.name);
  }
  return set;
}

GroupVariation VariationOf(const CorrespondedSet& set,
                           const std::string& name,
                           const std::vector<size_t>& members,
                           Executor& executor) {
  constexpr int64_t kVerticesAtOnce = 1024;
  const int64_t vertices = set.mean_shape.VertexCount();
  GroupVariation group;
  group.name = name;
  group.meshes = std::ssize(members);
  group.metrics.resize(static_cast<size_t>(vertices));
  group.deviation.resize(static_cast<size_t>(vertices));
  group.signed_mean.resize(static_cast<size_t>(vertices));
  group.mean_displacement = Eigen::Matrix3Xd::Zero(3, vertices);
  const auto measure = [&](int64_t vertex) {
    const auto at = static_cast<size_t>(vertex);
    std::vector<double> distances;
    double sum = 0;
    double squares = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const size_t member : members) {
      const Eigen::Vector3d step = set.displacements[member].col(vertex).cast<double>();
      const double distance = step.norm();
      const double with_sign = std::copysign(distance, step.dot(set.normals.col(vertex)));
      distances.push_back(distance);
      sum += with_sign;
      squares += with_sign * with_sign;
      mean += step;
    }
    const auto count = static_cast<double>(members.size());
    group.metrics[at] = MetricsOfDistances(distances);
    group.signed_mean[at] = sum / count;
    group.deviation[at] = members.size() < 2
                              ? 0
                              : std::sqrt(std::max(0.0, squares - sum * sum / count) / (count - 1));
    group.mean_displacement.col(vertex) = mean / count;
  };
  executor.ParallelFor((vertices + kVerticesAtOnce - 1) / kVerticesAtOnce, [&](int64_t block) {
    const int64_t end = std::min(vertices, (block + 1) * kVerticesAtOnce);
    for (int64_t vertex = block * kVerticesAtOnce; vertex < end; ++vertex) {
      measure(vertex);
    }
  });
  return group;
}

}  // namespace cohort
