#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// What ingest found and mended in one mesh. Counts up to duplicate_faces are of the mesh as read
/// from the file; the rest is of what remains.
struct MeshHealth {
  int64_t vertices = 0;
  int64_t faces = 0;
  int64_t duplicate_vertices = 0;     ///< Vertices at exactly the position of an earlier one; kept.
  int64_t unreferenced_vertices = 0;  ///< In no face that remains; removed from a mesh with faces.
  int64_t degenerate_faces = 0;       ///< Twice the same vertex (removed) or no area (kept).
  int64_t duplicate_faces = 0;        ///< Same three vertices as an earlier face; removed.
  int64_t non_manifold_edges = 0;     ///< Edges of three or more faces, or used twice one way.
  int64_t components = 0;             ///< Connected pieces (by shared vertices); 1 for a cloud.
  double largest_component_share = 0;  ///< Of all faces (of all vertices in a cloud), 0..1.
  double boundary_share = 0;           ///< Edges with one face / all edges, 0..1.
  double diagonal = 0;                 ///< Of the bounding box, mesh units.
  double rms_radius = 0;    ///< Root mean square distance of vertices from their centroid.
  double surface_area = 0;  ///< Square mesh units; 0 for a cloud.
  bool point_cloud = false;
  /// One line each, for people: what is unusual, e.g. "4 components; the largest has 97 % of
  /// faces".
  std::vector<std::string> warnings;
};

/// Checks `mesh`, removes what no later step can use (faces with a repeated vertex, duplicate
/// faces, unreferenced vertices of a mesh with faces) and reports it.
///
/// @param mesh  changed in place; the order of what remains is kept.
/// @return kInvalidArgument if a coordinate is not finite or beyond +-1e6, an index is out of
/// range,
///         or nothing usable remains (fewer than 3 vertices, or all points coincide). The message
///         names the vertex or face (0-based) and the numbers, not the file.
[[nodiscard]] absl::Status CheckAndClean(TriangleMesh& mesh, MeshHealth& health);

}  // namespace cohort
