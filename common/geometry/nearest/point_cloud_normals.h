#pragma once

#include <optional>

#include <Eigen/Core>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace cohort {

struct PointCloudNormalsOptions {
  int neighbours = 12;  ///< Vertices that a plane is fitted to, the vertex itself included; >= 3.
  /// Direction from the surface towards the viewer (the scanner); not zero. Without one, normals
  /// point outward from the centroid.
  std::optional<Eigen::Vector3d> view_direction = std::nullopt;
  [[nodiscard]] absl::Status Validate() const;
};

/// Unit normals of a point cloud, 3 x n.
///
/// Direction: least principal axis of the k nearest vertices. Sign: made consistent along a minimum
/// spanning tree of the k-nearest graph with weights 1 - |n_i . n_j|; then each connected piece is
/// turned as a whole so that the sum of n_i . (p_i - centroid of all points) is positive, or with a
/// view direction the sum of n_i . view. Where that sum is nothing but rounding (a plane), the
/// largest component of the normal of the piece's lowest vertex is made positive.
/// A vertex whose k nearest all coincide gets (0, 0, 0).
/// @param vertices  3 x n, finite, mesh units.
/// @return kInvalidArgument for bad options or n < 3.
/// Source: Hoppe et al. 1992, section 3.3; which way is outward: ours.
[[nodiscard]] absl::StatusOr<Eigen::Matrix3Xd> PointCloudNormals(
    const Eigen::Ref<const Eigen::Matrix3Xd>& vertices, const PointCloudNormalsOptions& options);

}  // namespace cohort
