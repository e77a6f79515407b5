#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Points whose Euclidean distances come close to those of a matrix.
struct Ordination {
  Eigen::MatrixXd coordinates;      ///< N x k, the metric's unit; axis j has variance share j.
  std::vector<double> eigenvalues;  ///< All N of the doubly centred matrix, descending.
  std::vector<double> explained;    ///< k shares of the sum of the positive eigenvalues.
  int64_t negative = 0;             ///< Eigenvalues below -1e-10 of the largest: not Euclidean.
  double negative_share = 0;        ///< |sum of those| / sum of |all|.
};

/// Principal coordinates (classical scaling): eigenvectors of -1/2 J D^2 J times the root of their
/// eigenvalues. Axes whose eigenvalue is not above 1e-10 of the largest are left out, so there may
/// be fewer than `axes`; none if all meshes coincide.
///
/// Each axis is turned such that its coordinate of largest magnitude is positive (of equal ones, to
/// a millionth, the first). O(N^3) time, three N x N matrices.
/// @param axes  >= 1.
/// @return kInvalidArgument if axes < 1; as RequireDissimilarities (3 meshes) and RequireComplete.
/// Source: Gower 1966; R's cmdscale.
[[nodiscard]] absl::StatusOr<Ordination> OrdinateMeshes(const MetricMatrix& distances, int axes);

}  // namespace cohort
