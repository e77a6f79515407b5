#pragma once

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/correspondence.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// The mesh reflected in the plane x = centroid of its vertices: x' = 2 c_x - x. The corners of
/// the faces are taken the other way round, so that what was outside stays outside.
///
/// Any other plane would give the same shape, moved rigidly; so for a symmetrised copy it is the
/// alignment that finds where the plane of symmetry lies.
[[nodiscard]] TriangleMesh MirroredMesh(const TriangleMesh& mesh);

/// A symmetric version of a mesh, and how far from symmetric the mesh is.
struct SymmetricMesh {
  TriangleMesh mesh;  ///< The faces of the original with the moved vertices, where it lay.
  /// RMS over the vertices of how far they moved: half of the way to the mirrored mesh. Vertices
  /// whose nearest mirrored vertex lies on the open boundary do not count: there the cut of the
  /// mesh differs from side to side, not the shape. 0 if none counts.
  double asymmetry = 0;
};

/// Each vertex moves halfway to its partner on the mirrored copy aligned with the mesh.
///
/// With kVertex the partner is the nearest vertex: nothing moves if the mesh is exactly symmetric
/// and its vertices come in mirrored pairs, otherwise the result is as symmetric as the vertices
/// are dense. With kSurface it is the nearest point of the faces, and the density matters little.
/// @param mesh  at least one vertex; for kSurface at least one face.
/// @param T_mesh_mirrored  aligns MirroredMesh(mesh) with `mesh`.
/// Source: predecessor a2 ("Symmetrical models"), with c12's defects (the shift, faces inside out)
///         put right; the surface and the asymmetry are ours.
[[nodiscard]] SymmetricMesh SymmetrizeMesh(const TriangleMesh& mesh,
                                           const Similarity& T_mesh_mirrored,
                                           Correspondence correspondence);

/// SymmetrizeMesh with the alignment found: coarse pose of the mirrored copy, then rigid ICP until
/// it converges. Partners are the nearest points of the surface, for a point cloud the vertices.
///
/// @param pairs  only its trimmed share (0.1 if less is asked) and distance limit count.
/// @return as FindCoarsePose and AlignByIcp; kFailedPrecondition also if ICP did not converge.
[[nodiscard]] absl::StatusOr<SymmetricMesh> MakeSymmetric(const TriangleMesh& mesh,
                                                          const IcpOptions& pairs,
                                                          PacketSearch& search);

}  // namespace cohort
