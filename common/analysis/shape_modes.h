#pragma once

#include <vector>

#include <absl/status/statusor.h>
#include <Eigen/Core>

namespace cohort {

/// How corresponded shapes differ: principal components of their vertices.
struct ShapeModes {
  Eigen::Matrix3Xd mean;  ///< 3 x n.
  /// k modes of unit RMS length over the vertices, orthogonal, 3 x n each: shape = mean + score x
  /// mode.
  std::vector<Eigen::Matrix3Xd> modes;
  std::vector<double> deviations;  ///< k standard deviations of the scores (N - 1), mm RMS.
  std::vector<double> explained;   ///< k shares of the total variance.
  Eigen::MatrixXd scores;          ///< N x k, mm RMS over the vertices.
  double total_variance = 0;       ///< Of all modes, mm^2 (mean square over the vertices).
};

/// By the N x N matrix of inner products: O(N^2 n) time, no matrix of n x n. Modes whose variance
/// is below 1e-10 of the largest are left out, so there may be fewer than `count`; none if all
/// shapes are equal. Each mode is turned such that the score of largest magnitude is positive (of
/// equal ones, to a millionth, the first).
/// @param displacements  N >= 2 of 3 x n: shapes less one common shape (which adds to the mean).
/// @param common  3 x n.
/// @return kInvalidArgument for fewer than 2 shapes, other sizes, or count < 1.
/// Source: Sirovich 1987 (snapshots); Cootes et al. 1995 (point distribution model).
[[nodiscard]] absl::StatusOr<ShapeModes> FindShapeModes(
    const std::vector<Eigen::Matrix3Xf>& displacements,
    const Eigen::Ref<const Eigen::Matrix3Xd>& common,
    int count);

}  // namespace cohort
