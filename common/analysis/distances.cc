#include "common/analysis/distances.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string_view>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// "anna.ply, bob.ply".
std::string Pair(const MatrixView& matrix, Eigen::Index row, Eigen::Index column) {
  return absl::StrCat(matrix.labels[static_cast<size_t>(row)], ", ",
                      matrix.labels[static_cast<size_t>(column)]);
}

absl::Status RequireShape(const MatrixView& matrix, int64_t least) {
  const Eigen::Index rows = matrix.values.rows();
  if (rows != matrix.values.cols()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the matrix has ", rows, " rows and ", matrix.values.cols(), " columns"));
  }
  if (std::ssize(matrix.labels) != rows) {
    return absl::InvalidArgumentError(
        absl::StrCat("the matrix has ", rows, " rows and ", matrix.labels.size(), " labels"));
  }
  if (rows < least) {
    return absl::InvalidArgumentError(absl::StrCat("the matrix has ", rows,
                                                   rows == 1 ? " mesh" : " meshes", ", at least ",
                                                   least, " are needed"));
  }
  std::set<std::string_view> labels;
  for (const std::string& label : matrix.labels) {
    if (!labels.insert(label).second) {
      return absl::InvalidArgumentError(absl::StrCat("mesh ", label, " is there twice"));
    }
  }
  return absl::OkStatus();
}

bool Agree(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) {
    return std::isnan(a) && std::isnan(b);
  }
  return a == b || std::abs(a - b) <= kSymmetryTolerance * std::max(std::abs(a), std::abs(b));
}

}  // namespace

absl::Status RequireSymmetric(const MatrixView& matrix, int64_t least) {
  COHORT_RETURN_IF_ERROR(RequireShape(matrix, least));
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    for (Eigen::Index column = 0; column < row; ++column) {
      const double lower = matrix.values(row, column);
      const double upper = matrix.values(column, row);
      if (!Agree(lower, upper)) {
        return absl::InvalidArgumentError(
            absl::StrCat("the matrix is not symmetric: ", Pair(matrix, row, column), " is ", lower,
                         ", ", Pair(matrix, column, row), " is ", upper));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status RequireDissimilarities(const MatrixView& matrix, int64_t least) {
  COHORT_RETURN_IF_ERROR(RequireSymmetric(matrix, least));
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    for (Eigen::Index column = 0; column <= row; ++column) {
      const double value = matrix.values(row, column);
      if (value < 0 || std::isinf(value)) {
        return absl::InvalidArgumentError(
            absl::StrCat("the value of ", Pair(matrix, row, column), " is ", value,
                         ", which is no distance (zero or more, finite)"));
      }
      if (row == column && value > 0) {
        return absl::InvalidArgumentError(
            absl::StrCat("the distance of ", matrix.labels[static_cast<size_t>(row)],
                         " from itself is ", value, ", not 0: is it a matrix of similarities?"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status RequireComplete(const MatrixView& matrix) {
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.values.cols(); ++column) {
      if (row != column && std::isnan(matrix.values(row, column))) {
        return absl::FailedPreconditionError(
            absl::StrCat("the value of ", Pair(matrix, row, column), " is missing"));
      }
    }
  }
  return absl::OkStatus();
}

std::vector<int64_t> CompleteMeshes(const MatrixView& matrix) {
  const Eigen::Index count = matrix.values.rows();
  const auto is_missing = [&](Eigen::Index row, Eigen::Index column) {
    return row != column &&
           (std::isnan(matrix.values(row, column)) || std::isnan(matrix.values(column, row)));
  };
  std::vector<int64_t> missing(static_cast<size_t>(count));
  for (Eigen::Index row = 0; row < count; ++row) {
    for (Eigen::Index column = 0; column < count; ++column) {
      missing[static_cast<size_t>(row)] += is_missing(row, column) ? 1 : 0;
    }
  }
  std::vector<int64_t> kept(static_cast<size_t>(count));
  std::iota(kept.begin(), kept.end(), int64_t{0});
  while (!kept.empty()) {
    // Of several with the most, the last: the reversed order makes it the first maximum.
    const auto worst = *std::max_element(kept.rbegin(), kept.rend(), [&](int64_t a, int64_t b) {
      return missing[static_cast<size_t>(a)] < missing[static_cast<size_t>(b)];
    });
    if (missing[static_cast<size_t>(worst)] == 0) {
      break;
    }
    kept.erase(std::find(kept.begin(), kept.end(), worst));
    for (const int64_t mesh : kept) {
      missing[static_cast<size_t>(mesh)] -= is_missing(mesh, worst) ? 1 : 0;
    }
  }
  return kept;
}

MetricMatrix PartOf(const MatrixView& matrix, const std::vector<int64_t>& meshes) {
  MetricMatrix part;
  part.values = matrix.values(meshes, meshes);
  part.labels.reserve(meshes.size());
  for (const int64_t mesh : meshes) {
    part.labels.push_back(matrix.labels[static_cast<size_t>(mesh)]);
  }
  return part;
}

std::vector<double> LowerTriangle(const RowMajorMatrix& values) {
  std::vector<double> triangle;
  triangle.reserve(static_cast<size_t>(values.rows() * (values.rows() - 1) / 2));
  for (Eigen::Index row = 1; row < values.rows(); ++row) {
    for (Eigen::Index column = 0; column < row; ++column) {
      triangle.push_back(values(row, column));
    }
  }
  return triangle;
}

}  // namespace cohort
