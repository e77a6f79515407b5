#pragma once

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// The mesh reflected in the plane x = centroid of its vertices: x' = 2 c_x - x. The corners of
/// the faces are taken the other way round, so that what was outside stays outside.
///
/// Any other plane would give the same shape, moved rigidly; so for a symmetrised copy it is the
/// alignment that finds where the plane of symmetry lies.
[[nodiscard]] TriangleMesh MirroredMesh(const TriangleMesh& mesh);

/// A symmetric version of a nearly symmetric mesh: each vertex moves halfway to the nearest vertex
/// of the mirrored copy aligned with the mesh.
///
/// For an exactly symmetric mesh whose vertices come in mirrored pairs nothing moves. Otherwise the
/// result is as symmetric as the vertices are dense.
/// @param mesh  at least one vertex.
/// @param T_mesh_mirrored  aligns MirroredMesh(mesh) with `mesh`; the caller runs the ICP.
/// @return the faces of `mesh` with the moved vertices.
/// Source: predecessor a2 ("Symmetrical models"), with c12's defects (the shift, faces inside out)
///         put right.
[[nodiscard]] TriangleMesh SymmetrizedMesh(const TriangleMesh& mesh,
                                           const Similarity& T_mesh_mirrored);

}  // namespace cohort
