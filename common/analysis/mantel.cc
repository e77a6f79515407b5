#include "common/analysis/mantel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/analysis/permutations.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr int64_t kMostPermutations = 10'000'000;
/// A third matrix that says all of another leaves nothing to correlate.
constexpr double kSameMatrix = 1e-12;

/// Ranks from 1 in place of values; equal values share the mean of their ranks.
void RankInPlace(std::vector<double>& values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t x, size_t y) { return std::pair(values[x], x) < std::pair(values[y], y); });
  for (size_t first = 0; first < order.size();) {
    const double value = values[order[first]];
    size_t end = first;
    while (end < order.size() && values[order[end]] == value) {
      ++end;
    }
    const double rank = 0.5 * static_cast<double>(first + 1 + end);
    for (size_t i = first; i < end; ++i) {
      values[order[i]] = rank;
    }
    first = end;
  }
}

/// Values (or ranks) of the pairs with mean 0 and sum of squares 1, as a symmetric matrix.
absl::StatusOr<RowMajorMatrix> Standardized(const MetricMatrix& matrix, Correlation correlation) {
  COHORT_RETURN_IF_ERROR(RequireSymmetric(matrix, 3));
  COHORT_RETURN_IF_ERROR(RequireComplete(matrix));
  std::vector<double> values = LowerTriangle(matrix.values);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  if (*low == *high) {
    return absl::FailedPreconditionError(
        absl::StrCat("the matrix is constant: every pair is ", *low));
  }
  if (!std::isfinite(*low) || !std::isfinite(*high)) {
    return absl::InvalidArgumentError("the matrix has an infinite value");
  }
  if (correlation == Correlation::kSpearman) {
    RankInPlace(values);
  }
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  const double mean = sum / static_cast<double>(values.size());
  double squares = 0;
  for (double& value : values) {
    value -= mean;
    squares += value * value;
  }
  const double norm = std::sqrt(squares);
  RowMajorMatrix standardized = RowMajorMatrix::Zero(matrix.values.rows(), matrix.values.cols());
  size_t next = 0;
  for (Eigen::Index row = 1; row < standardized.rows(); ++row) {
    for (Eigen::Index column = 0; column < row; ++column) {
      standardized(row, column) = values[next++] / norm;
      standardized(column, row) = standardized(row, column);
    }
  }
  return standardized;
}

/// Correlation of `a`, its meshes in another order, with `b`.
double Correlate(const RowMajorMatrix& a,
                 const std::vector<int32_t>& order,
                 const RowMajorMatrix& b) {
  double sum = 0;
  for (Eigen::Index row = 1; row < b.rows(); ++row) {
    const double* of_a = a.row(order[static_cast<size_t>(row)]).data();
    const double* of_b = b.row(row).data();
    // Two sums, so that one addition need not wait for the other.
    double even = 0;
    double odd = 0;
    Eigen::Index column = 0;
    for (; column + 1 < row; column += 2) {
      even += of_a[order[static_cast<size_t>(column)]] * of_b[column];
      odd += of_a[order[static_cast<size_t>(column + 1)]] * of_b[column + 1];
    }
    if (column < row) {
      even += of_a[order[static_cast<size_t>(column)]] * of_b[column];
    }
    sum += even + odd;
  }
  return sum;
}

bool IsAsExtreme(double permuted, double found, Alternative alternative) {
  return alternative == Alternative::kGreater
             ? permuted >= found - kPermutationTolerance
             : std::abs(permuted) >= std::abs(found) - kPermutationTolerance;
}

absl::Status RequireSameLabels(const MetricMatrix& a, const MetricMatrix& b) {
  if (a.labels != b.labels) {
    return absl::InvalidArgumentError(
        absl::StrCat("the matrices are not of the same meshes in the same order (", a.labels.size(),
                     " and ", b.labels.size(), " meshes)"));
  }
  return absl::OkStatus();
}

std::vector<int32_t> Unchanged(Eigen::Index meshes) {
  std::vector<int32_t> order(static_cast<size_t>(meshes));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// `statistic` of the order as it is and of random ones.
template <typename Statistic>
MantelResult Permute(Eigen::Index meshes,
                     const MantelOptions& options,
                     const Statistic& statistic,
                     Executor& executor) {
  MantelResult result;
  result.r = statistic(Unchanged(meshes));
  result.meshes = meshes;
  result.permutations = options.permutations;
  result.as_extreme = CountExtremeOrders(
      meshes, options.permutations, options.seed,
      [&](const std::vector<int32_t>& order) {
        return IsAsExtreme(statistic(order), result.r, options.alternative);
      },
      executor);
  result.p =
      static_cast<double>(1 + result.as_extreme) / static_cast<double>(1 + result.permutations);
  return result;
}

}  // namespace

absl::Status MantelOptions::Validate() const {
  if (permutations < 1 || permutations > kMostPermutations) {
    return absl::InvalidArgumentError(
        absl::StrCat("permutations: ", permutations, ", expected 1 to ", kMostPermutations));
  }
  return absl::OkStatus();
}

absl::StatusOr<MantelResult> MantelTest(const MetricMatrix& a,
                                        const MetricMatrix& b,
                                        const MantelOptions& options,
                                        Executor& executor) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  COHORT_RETURN_IF_ERROR(RequireSameLabels(a, b));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix x, Standardized(a, options.correlation));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix y, Standardized(b, options.correlation));
  return Permute(
      x.rows(), options, [&](const std::vector<int32_t>& order) { return Correlate(x, order, y); },
      executor);
}

absl::StatusOr<MantelResult> PartialMantelTest(const MetricMatrix& a,
                                               const MetricMatrix& b,
                                               const MetricMatrix& given,
                                               const MantelOptions& options,
                                               Executor& executor) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  COHORT_RETURN_IF_ERROR(RequireSameLabels(a, b));
  COHORT_RETURN_IF_ERROR(RequireSameLabels(a, given));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix x, Standardized(a, options.correlation));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix y, Standardized(b, options.correlation));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix z, Standardized(given, options.correlation));
  const double yz = Correlate(y, Unchanged(y.rows()), z);
  const double xz = Correlate(x, Unchanged(x.rows()), z);
  if (1 - yz * yz < kSameMatrix || 1 - xz * xz < kSameMatrix) {
    return absl::FailedPreconditionError(
        "the matrix to be taken out says all that one of the others does: nothing is left");
  }
  return Permute(
      x.rows(), options,
      [&](const std::vector<int32_t>& order) {
        const double permuted_xz = Correlate(x, order, z);
        return (Correlate(x, order, y) - permuted_xz * yz) /
               std::sqrt((1 - permuted_xz * permuted_xz) * (1 - yz * yz));
      },
      executor);
}

}  // namespace cohort
