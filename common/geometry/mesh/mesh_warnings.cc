#include "common/geometry/mesh/mesh_warnings.h"

#include <cmath>

#include <absl/strings/str_cat.h>

#include "common/geometry/mesh/bounds.h"

namespace cohort {
namespace {

constexpr double kManyBoundaryEdges = 0.1;
constexpr double kSmallestPlausibleDiagonal = 20;
constexpr double kLargestPlausibleDiagonal = 1000;
// Positions are kept as float32: half a step of them, as a share of the diagonal, that matters.
constexpr double kCoarsePositions = 1e-5;

/// A share for people; rounded down, so that 100 % always means all.
std::string Percent(double share) {
  return absl::StrCat(std::floor(1000 * share) / 10, " %");
}

/// The unit in which the extent would be that of a face or a bone.
const char* LikelyUnit(double diagonal) {
  if (diagonal >= 0.02 && diagonal <= 1) {
    return "metres?";
  }
  if (diagonal > 1 && diagonal < kSmallestPlausibleDiagonal) {
    return "centimetres or inches?";
  }
  return diagonal >= 2e4 ? "micrometres?" : "another unit?";
}

void WarnOfExtent(const TriangleMesh& mesh,
                  const MeshHealth& health,
                  std::vector<std::string>& warnings) {
  const double half_step = 0x1p-25 * mesh.vertices.cwiseAbs().maxCoeff();
  if (half_step > kCoarsePositions * health.diagonal) {
    warnings.push_back(absl::StrCat("lies far from the origin for its size; positions are ",
                                    "kept as 32-bit floats, to about ", half_step));
  }
  if (health.diagonal < kSmallestPlausibleDiagonal || health.diagonal > kLargestPlausibleDiagonal) {
    const Bounds bounds = BoundsOf(mesh.vertices);
    warnings.push_back(absl::StrCat("largest extent is ", (bounds.high - bounds.low).maxCoeff(),
                                    ": ", LikelyUnit(health.diagonal),
                                    " Cohort assumes millimetres"));
  }
}

}  // namespace

std::vector<std::string> MeshWarnings(const TriangleMesh& mesh,
                                      const MeshHealth& health,
                                      Mending mending) {
  const bool removed = mending == Mending::kRemoved;
  std::vector<std::string> warnings;
  const auto warn_if = [&warnings](int64_t count, const char* what) {
    if (count > 0) {
      warnings.push_back(absl::StrCat(count, what));
    }
  };
  if (health.point_cloud) {
    warnings.emplace_back("a point cloud: no faces, so nothing that needs a surface works");
  }
  if (health.components > 1) {
    warnings.push_back(absl::StrCat(health.components, " components; the largest has ",
                                    Percent(health.largest_component_share), " of the faces"));
  }
  if (health.boundary_share > kManyBoundaryEdges) {
    warnings.push_back(absl::StrCat(Percent(health.boundary_share),
                                    " of the edges are boundary: many holes or loose pieces"));
  }
  warn_if(health.unreferenced_vertices,
          removed ? " vertices in no face removed" : " vertices in no face");
  warn_if(health.degenerate_faces,
          removed ? " degenerate faces (a vertex twice: removed; no area: kept)"
                  : " degenerate faces (a vertex twice, or no area)");
  warn_if(health.duplicate_faces,
          removed ? " duplicate faces removed" : " faces that are there twice");
  warn_if(health.non_manifold_edges, " edges are not manifold");
  warn_if(health.duplicate_vertices, " vertices lie exactly on earlier ones");
  WarnOfExtent(mesh, health, warnings);
  return warnings;
}

}  // namespace cohort
