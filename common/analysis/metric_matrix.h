#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/comparison/metrics.h"

namespace cohort {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// N x N numbers with a label per mesh. Row = source (its vertices are measured), column = target.
struct MetricMatrix {
  std::vector<std::string> labels;  ///< N, in the job's order.
  RowMajorMatrix values;            ///< NaN: not measured.
};

/// How the two directed values of a pair become one; names as in common/jobs/job_spec.h.
enum class PairRule { kMean, kMax };

/// Symmetric matrix from a directed one; NaN if either direction is NaN.
[[nodiscard]] MetricMatrix Symmetrized(const MetricMatrix& directed, PairRule rule);

/// The `count` smallest entries of each row without the diagonal, ascending; ties go to the lower
/// column; NaN is left out. Fewer if the row has fewer.
struct Neighbour {
  int64_t column = 0;
  double value = 0;
};
[[nodiscard]] std::vector<std::vector<Neighbour>> NearestNeighbours(const MetricMatrix& matrix,
                                                                    int count);

/// Pearson correlation of the off-diagonal entries of two N x N matrices (N >= 3); the statistic of
/// the Mantel test.
/// @return kInvalidArgument if the sizes differ or N < 3; kFailedPrecondition if one is constant.
/// Source: Mantel 1967.
[[nodiscard]] absl::StatusOr<double> MatrixCorrelation(const RowMajorMatrix& a,
                                                       const RowMajorMatrix& b);

}  // namespace cohort
