#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace cohort {

/// Distances with the side of the target on which each query lies.
struct SignedField {
  std::vector<float> distances;  ///< n, mesh units; + in front of the target, 0 where undecided.
  /// Queries that are not on the target and yet count as 0, because (p - c) . normal is 0: a vertex
  /// without a normal, or one that lies in its own tangent plane.
  int64_t undecided = 0;
};

/// Gives each distance d = |p - c| the sign of (p - c) . n_p: that of the QUERY's normal; of the
/// product 0 comes the distance 0.
/// Source: the predecessor (reference c7).
/// @param queries, normals  3 x n: the vertices p and their normals n_p (of any length).
/// @param target_vertices  3 x m, in the same frame.
/// @param nearest  n indices below m: the vertex c of each query.
/// @param squared_distances  n, as the search gave them; the distances are their float32 roots.
[[nodiscard]] SignedField SignedDistances(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                                          const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                                          const Eigen::Ref<const Eigen::Matrix3Xf>& target_vertices,
                                          std::span<const int32_t> nearest,
                                          std::span<const float> squared_distances);

/// The same for nearest points anywhere on the surface, 3 x n.
[[nodiscard]] SignedField SignedDistances(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                                          const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                                          const Eigen::Ref<const Eigen::Matrix3Xf>& nearest_points,
                                          std::span<const float> squared_distances);

}  // namespace cohort
