#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/base/scratch.h"
#include "common/geometry/comparison/metrics.h"

namespace cohort {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// N x N numbers with a label per mesh. Row = source (its vertices are measured), column = target.
struct MetricMatrix {
  std::vector<std::string> labels;  ///< N, in the job's order.
  RowMajorMatrix values;            ///< NaN: not measured.
};

/// A matrix of either kind, to read while it lives.
struct MatrixView {
  std::span<const std::string> labels;
  Eigen::Map<const RowMajorMatrix> values{nullptr, 0, 0};

  MatrixView() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): as a span is of a vector.
  MatrixView(const MetricMatrix& matrix)
      : labels(matrix.labels),
        values(matrix.values.data(), matrix.values.rows(), matrix.values.cols()) {}
  MatrixView(std::span<const std::string> its_labels, const double* its_values)
      : labels(its_labels), values(its_values, std::ssize(its_labels), std::ssize(its_labels)) {}
};

/// A metric matrix that may be larger than the machine's memory (common/base/scratch.h).
class LargeMatrix {
 public:
  LargeMatrix() = default;
  /// Nothing is measured: all values are NaN.
  explicit LargeMatrix(std::vector<std::string> labels);
  /// A copy.
  explicit LargeMatrix(const MatrixView& matrix);

  [[nodiscard]] const std::vector<std::string>& Labels() const { return labels_; }
  [[nodiscard]] Eigen::Map<RowMajorMatrix> Values() {
    return {values_.data(), std::ssize(labels_), std::ssize(labels_)};
  }
  [[nodiscard]] MatrixView View() const { return {labels_, values_.data()}; }

 private:
  std::vector<std::string> labels_;
  ScratchVector<double> values_;  ///< Row by row.
};

/// How the two directed values of a pair become one; names as in common/jobs/job_spec.h.
enum class PairRule { kMean, kMax };

/// Symmetric matrix from a directed one; NaN if either direction is NaN.
[[nodiscard]] MetricMatrix Symmetrized(const MatrixView& directed, PairRule rule);
/// The same in place.
/// @param values  N x N.
void Symmetrize(PairRule rule, Eigen::Ref<RowMajorMatrix> values);

/// The `count` smallest entries of each row without the diagonal, ascending; ties go to the lower
/// column; NaN is left out. Fewer if the row has fewer.
struct Neighbour {
  int64_t column = 0;
  double value = 0;
};
[[nodiscard]] std::vector<std::vector<Neighbour>> NearestNeighbours(const MatrixView& matrix,
                                                                    int count);

/// Pearson correlation of the off-diagonal entries of two N x N matrices (N >= 3); the statistic of
/// the Mantel test.
/// @return kInvalidArgument if the sizes differ or N < 3; kFailedPrecondition if one is constant.
/// Source: Mantel 1967.
[[nodiscard]] absl::StatusOr<double> MatrixCorrelation(const RowMajorMatrix& a,
                                                       const RowMajorMatrix& b);

}  // namespace cohort
