#pragma once

#include <Eigen/Core>

#include <absl/status/statusor.h>

namespace cohort {

/// x_target = scale * rotation * x_source + translation; written T_target_source.
struct Similarity {
  double scale = 1.0;                                      ///< Unitless, > 0.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< det = +1.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();   ///< Target units.

  /// 3 x n in, 3 x n out.
  [[nodiscard]] Eigen::Matrix3Xd Apply(const Eigen::Ref<const Eigen::Matrix3Xd>& points) const;
  [[nodiscard]] Eigen::Vector3d ApplyToPoint(const Eigen::Vector3d& point) const;
  [[nodiscard]] Similarity Inverse() const;
  /// T_c_a = T_c_b * T_b_a.
  friend Similarity operator*(const Similarity& T_c_b, const Similarity& T_b_a);
  /// 4 x 4, homogeneous, row-major when printed.
  [[nodiscard]] Eigen::Matrix4d Matrix() const;
};

enum class ScaleMode {
  kOff,   ///< Rigid: scale stays 1.
  kFree,  ///< Uniform scale that minimises the squared error: sum b'.(R a') / sum |a'|^2.
  /// Uniform scale sqrt(sum |b'|^2 / sum |a'|^2): the same whichever mesh moves. With
  /// nearest-vertex pairs, which err on both sides, the least-squares scale shrinks the source from
  /// pass to pass (regression dilution); this one does not favour either mesh.
  kSymmetric,
  /// From the x coordinates alone: the predecessor's (FidentisScale::kFromX). No fit of ours.
  kFromX,
};

/// Least-squares similarity between paired points: minimises sum_i |s R a_i + t - b_i|^2.
///
/// Centred sums; R from the unit quaternion of the largest eigenvalue of Horn's 4 x 4 matrix;
/// s = sum b'.(R a') / sum |a'|^2 (1 if scale is off); t = mean(b) - s R mean(a).
/// @param source, target  3 x n, column i of one is the partner of column i of the other.
/// @return kInvalidArgument if the widths differ, n < 3, or for kFromX; kFailedPrecondition if the
/// source points
///         coincide or the scale is not positive.
/// Source: Horn 1987, sections 2.D-4; thesis eq. 3.4-3.9.
[[nodiscard]] absl::StatusOr<Similarity> FitSimilarity(
    const Eigen::Ref<const Eigen::Matrix3Xd>& source,
    const Eigen::Ref<const Eigen::Matrix3Xd>& target,
    ScaleMode scale_mode);

}  // namespace cohort
