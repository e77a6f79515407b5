#include "common/geometry/registration/mirror.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/boundary.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/nearest/surface_search.h"
#include "common/geometry/registration/coarse_pose.h"
#include "common/geometry/registration/icp_mesh.h"

namespace cohort {
namespace {

/// What lies far from its mirror image is what makes the mesh asymmetric: it is not to say where
/// the plane of symmetry lies.
constexpr double kLeastTrimmedShare = 0.1;

/// The mesh and its aligned mirror image about one centre, as the searches read them: in float32.
struct Halves {
  Eigen::Vector3d center;
  Eigen::Matrix3Xd mirrored;  ///< 3 x n, aligned, mesh units.
  PackedMesh vertices;
  PackedMesh mirrored_vertices;
};

Halves MakeHalves(const TriangleMesh& mesh, const Similarity& T_mesh_mirrored) {
  const Eigen::Vector3d center = CentroidOf(mesh.vertices);
  Eigen::Matrix3Xd mirrored = T_mesh_mirrored.Apply(MirroredMesh(mesh).vertices);
  PackedMesh vertices((mesh.vertices.colwise() - center).cast<float>());
  PackedMesh mirrored_vertices((mirrored.colwise() - center).cast<float>());
  return {.center = center,
          .mirrored = std::move(mirrored),
          .vertices = std::move(vertices),
          .mirrored_vertices = std::move(mirrored_vertices)};
}

/// Of each vertex its nearest mirrored vertex.
std::vector<int32_t> NearestMirrored(const Halves& halves) {
  PacketSearch search;
  NearestSlots nearest;
  search.Find(halves.vertices, halves.mirrored_vertices, nearest);
  std::vector<int32_t> partner(static_cast<size_t>(halves.vertices.VertexCount()));
  for (int slot = 0; slot < halves.vertices.VertexCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    const auto found = static_cast<size_t>(nearest.slots[s]);
    partner[static_cast<size_t>(halves.vertices.VertexOfSlot()[s])] =
        halves.mirrored_vertices.VertexOfSlot()[found];
  }
  return partner;
}

/// Of each vertex its nearest point of the mirrored faces, 3 x n, mesh units.
Eigen::Matrix3Xd NearestMirroredPoints(const TriangleMesh& mesh, const Halves& halves) {
  // The mirrored faces are turned over; the nearest point does not know.
  const PackedSurface surface((halves.mirrored.colwise() - halves.center).cast<float>(),
                              mesh.faces);
  SurfaceSearch search;
  NearestOnSurface nearest;
  search.Find(halves.vertices, surface, nearest);
  Eigen::Matrix3Xd points(3, mesh.VertexCount());
  for (int slot = 0; slot < halves.vertices.VertexCount(); ++slot) {
    points.col(halves.vertices.VertexOfSlot()[static_cast<size_t>(slot)]) =
        nearest.PointOfSlot(slot).cast<double>() + halves.center;
  }
  return points;
}

}  // namespace

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

SymmetricMesh SymmetrizeMesh(const TriangleMesh& mesh,
                             const Similarity& T_mesh_mirrored,
                             Correspondence correspondence) {
  const Halves halves = MakeHalves(mesh, T_mesh_mirrored);
  const std::vector<int32_t> partner = NearestMirrored(halves);
  const Eigen::Matrix3Xd points = correspondence == Correspondence::kSurface
                                      ? NearestMirroredPoints(mesh, halves)
                                      : halves.mirrored(Eigen::all, partner);
  const std::vector<uint8_t> on_boundary = BoundaryVertices(mesh);
  SymmetricMesh symmetric{.mesh = mesh};
  double sum_of_squares = 0;
  int64_t counted = 0;
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    const Eigen::Vector3d way = 0.5 * (points.col(v) - mesh.vertices.col(v));
    symmetric.mesh.vertices.col(v) = 0.5 * (mesh.vertices.col(v) + points.col(v));
    if (on_boundary[static_cast<size_t>(partner[static_cast<size_t>(v)])] == 0) {
      sum_of_squares += way.squaredNorm();
      ++counted;
    }
  }
  if (counted > 0) {
    symmetric.asymmetry = std::sqrt(sum_of_squares / static_cast<double>(counted));
  }
  return symmetric;
}

absl::StatusOr<SymmetricMesh> MakeSymmetric(const TriangleMesh& mesh,
                                            const IcpOptions& pairs,
                                            PacketSearch& search) {
  const TriangleMesh mirrored = MirroredMesh(mesh);
  COHORT_ASSIGN_OR_RETURN(const CoarsePose pose, FindCoarsePose(mirrored, mesh));
  const bool has_faces = !mesh.IsPointCloud();
  const Correspondence correspondence =
      has_faces ? Correspondence::kSurface : Correspondence::kVertex;
  IcpOptions icp;
  icp.scale_mode = ScaleMode::kOff;
  icp.trimmed_share = std::max(kLeastTrimmedShare, pairs.trimmed_share);
  icp.distance_limit = pairs.distance_limit;
  icp.correspondence = correspondence;
  const IcpMesh source(mirrored.vertices);
  const IcpMesh target = has_faces ? IcpMesh::WithSurface(mesh) : IcpMesh(mesh.vertices);
  COHORT_ASSIGN_OR_RETURN(const Alignment alignment,
                          AlignByIcp(source, target, pose.T_target_source, icp, search));
  if (!alignment.converged) {
    return absl::FailedPreconditionError("the mirrored copy did not come to rest on the mesh in " +
                                         std::to_string(alignment.iterations) + " iterations");
  }
  return SymmetrizeMesh(mesh, alignment.T_target_source, correspondence);
}

}  // namespace cohort
