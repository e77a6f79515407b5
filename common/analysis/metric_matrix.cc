#include "common/analysis/metric_matrix.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

double Combined(double a, double b, PairRule rule) {
  if (std::isnan(a) || std::isnan(b)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return rule == PairRule::kMean ? 0.5 * (a + b) : std::max(a, b);
}

/// Entries off the diagonal, row by row.
std::vector<double> OffDiagonal(const RowMajorMatrix& matrix) {
  std::vector<double> entries;
  entries.reserve(static_cast<size_t>(matrix.size() - matrix.rows()));
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      if (row != column) {
        entries.push_back(matrix(row, column));
      }
    }
  }
  return entries;
}

/// Subtracts the mean.
/// @return kFailedPrecondition if an entry is not finite or all are equal.
absl::Status Centre(std::vector<double>& entries) {
  double sum = 0;
  for (const double entry : entries) {
    if (!std::isfinite(entry)) {
      return absl::FailedPreconditionError("matrix correlation: an entry was not measured");
    }
    sum += entry;
  }
  const auto [low, high] = std::minmax_element(entries.begin(), entries.end());
  if (*low == *high) {
    return absl::FailedPreconditionError(
        absl::StrCat("matrix correlation: all entries are ", *low));
  }
  const double mean = sum / static_cast<double>(entries.size());
  for (double& entry : entries) {
    entry -= mean;
  }
  return absl::OkStatus();
}

double Dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

}  // namespace

LargeMatrix::LargeMatrix(std::vector<std::string> labels)
    : labels_(std::move(labels)),
      values_(labels_.size() * labels_.size(), std::numeric_limits<double>::quiet_NaN()) {}

LargeMatrix::LargeMatrix(const MatrixView& matrix)
    : labels_(matrix.labels.begin(), matrix.labels.end()),
      values_(matrix.values.data(), matrix.values.data() + matrix.values.size()) {
  assert(matrix.values.rows() == std::ssize(labels_) &&
         matrix.values.cols() == std::ssize(labels_));
}

MetricMatrix Symmetrized(const MatrixView& directed, PairRule rule) {
  MetricMatrix symmetric{{directed.labels.begin(), directed.labels.end()}, directed.values};
  Symmetrize(rule, symmetric.values);
  return symmetric;
}

void Symmetrize(PairRule rule, Eigen::Ref<RowMajorMatrix> values) {
  assert(values.rows() == values.cols());
  // Square by square, so that both halves of a large matrix are walked through once.
  constexpr Eigen::Index kSide = 512;
  const Eigen::Index count = values.rows();
  for (Eigen::Index top = 0; top < count; top += kSide) {
    for (Eigen::Index left = top; left < count; left += kSide) {
      for (Eigen::Index row = top; row < std::min(top + kSide, count); ++row) {
        for (Eigen::Index column = std::max(left, row); column < std::min(left + kSide, count);
             ++column) {
          const double there = values(row, column);
          const double back = values(column, row);
          values(row, column) = Combined(there, back, rule);
          values(column, row) = Combined(back, there, rule);
        }
      }
    }
  }
}

std::vector<std::vector<Neighbour>> NearestNeighbours(const MatrixView& matrix, int count) {
  assert(count >= 0);
  std::vector<std::vector<Neighbour>> neighbours;
  neighbours.reserve(static_cast<size_t>(matrix.values.rows()));
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    std::vector<Neighbour> all;
    for (Eigen::Index column = 0; column < matrix.values.cols(); ++column) {
      if (column != row && !std::isnan(matrix.values(row, column))) {
        all.push_back({column, matrix.values(row, column)});
      }
    }
    const std::ptrdiff_t kept = std::min(std::ptrdiff_t{count}, std::ssize(all));
    std::partial_sort(all.begin(), all.begin() + kept, all.end(),
                      [](const Neighbour& a, const Neighbour& b) {
                        return a.value != b.value ? a.value < b.value : a.column < b.column;
                      });
    all.resize(static_cast<size_t>(kept));
    neighbours.push_back(std::move(all));
  }
  return neighbours;
}

absl::StatusOr<double> MatrixCorrelation(const RowMajorMatrix& a, const RowMajorMatrix& b) {
  if (a.rows() != a.cols() || b.rows() != b.cols() || a.rows() != b.rows() || a.rows() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("matrix correlation: needs two N x N matrices, N >= 3, got ", a.rows(), " x ",
                     a.cols(), " and ", b.rows(), " x ", b.cols()));
  }
  std::vector<double> x = OffDiagonal(a);
  std::vector<double> y = OffDiagonal(b);
  for (std::vector<double>* entries : {&x, &y}) {
    if (absl::Status status = Centre(*entries); !status.ok()) {
      return status;
    }
  }
  return Dot(x, y) / std::sqrt(Dot(x, x) * Dot(y, y));
}

}  // namespace cohort
