#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "common/geometry/nearest/surface_search.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// Displacement of each reference vertex to its nearest vertex of one aligned mesh:
/// u_k = nearest(k) - reference_k, 3 x n (n = reference vertices). n look-ups, in the source's
/// frame: a similarity does not change which vertex is nearest, so the aligned mesh needs no index.
///
/// @param reference  3 x n, reference units; `packed_reference` the same.
/// @param source  3 x m, source units; `packed_source` the same.
/// Source: thesis eq. 3.22-3.23.
[[nodiscard]] Eigen::Matrix3Xd DisplacementToMesh(
    const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
    const IcpMesh& packed_reference,
    const Eigen::Ref<const Eigen::Matrix3Xd>& source,
    const IcpMesh& packed_source,
    const Similarity& T_reference_source,
    PacketSearch& search);

/// The same to the nearest point of the surface of the mesh: does not depend on how dense its
/// vertices are.
///
/// @param packed_source  with its surface (IcpMesh::WithSurface), source units.
[[nodiscard]] Eigen::Matrix3Xd DisplacementToSurface(
    const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
    const IcpMesh& packed_reference,
    const IcpMesh& packed_source,
    const Similarity& T_reference_source,
    SurfaceSearch& search);

/// reference_k + (1 / mesh_count) * sum of the partial sums, added in the given order.
/// @param partial_sums  each 3 x n: sums of displacements of disjoint batches of meshes.
/// @param mesh_count  meshes in all batches, >= 1.
/// Source: thesis eq. 3.24.
[[nodiscard]] Eigen::Matrix3Xd MoveByMeanDisplacement(
    const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
    std::span<const Eigen::Matrix3Xd> partial_sums,
    int64_t mesh_count);

}  // namespace cohort
