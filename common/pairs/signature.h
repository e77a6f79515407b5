#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cohort {

/// A mesh in a few numbers: where it lies, seen from some vertices of the reference that all meshes
/// of a job were aligned to. Meshes whose signatures are near (CorrespondedRms) are candidates for
/// being near; only the exact comparison tells.
inline constexpr int64_t kSignaturePoints = 512;

/// The vertices of a reference of n >= 1 vertices that signatures are taken at, ascending: all, or
/// kSignaturePoints spread evenly over their order, which is one of neighbours since the mesh went
/// through Draco.
[[nodiscard]] std::vector<int32_t> SignatureVertices(int64_t n);

/// @param displacements  3 x n, from every vertex of the reference to the aligned mesh.
/// @return 3 x SignatureVertices(n).size().
[[nodiscard]] Eigen::Matrix3Xf SignatureOf(const Eigen::Ref<const Eigen::Matrix3Xd>& displacements);

}  // namespace cohort
