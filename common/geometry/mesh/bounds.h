#pragma once

#include <Eigen/Core>

namespace cohort {

/// Axis-aligned box.
struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  [[nodiscard]] Eigen::Vector3d Center() const { return 0.5 * (low + high); }
  [[nodiscard]] double Diagonal() const { return (high - low).norm(); }
};

/// Box of the points (3 x n, n >= 1).
[[nodiscard]] Bounds BoundsOf(const Eigen::Ref<const Eigen::Matrix3Xd>& points);

/// Mean of the points (3 x n, n >= 1), summed in index order.
[[nodiscard]] Eigen::Vector3d CentroidOf(const Eigen::Ref<const Eigen::Matrix3Xd>& points);

/// Root mean square distance of the points (3 x n, n >= 1) from their centroid.
[[nodiscard]] double RmsRadius(const Eigen::Ref<const Eigen::Matrix3Xd>& points);

}  // namespace cohort
