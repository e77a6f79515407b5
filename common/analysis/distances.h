#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

// What the statistics of this folder ask of a matrix. Missing cells are NaN. A statistic of pairs
// (neighbours, groups, outliers, identification) leaves missing pairs out; one of the whole matrix
// (Mantel, clustering, ordination, PERMANOVA) refuses them: take CompleteMeshes first. Rejected
// meshes have no row and no column.

/// Values of a pair may differ by this share: text files keep 15 digits, not 17.
inline constexpr double kSymmetryTolerance = 1e-9;

/// @return kInvalidArgument, naming the meshes, if the matrix is not square, has another number of
///         labels than rows, a label twice, under `least` meshes, or a pair whose two values differ
///         by more than kSymmetryTolerance (one of them missing counts as differing). The diagonal
///         is not looked at.
[[nodiscard]] absl::Status RequireSymmetric(const MatrixView& matrix, int64_t least);

/// The same, and values that can be distances.
/// @return also kInvalidArgument, naming the meshes, for a value below zero, an infinite one, or a
///         diagonal that is neither zero nor missing.
[[nodiscard]] absl::Status RequireDissimilarities(const MatrixView& matrix, int64_t least);

/// @return kFailedPrecondition, naming a pair, if a value off the diagonal is missing.
[[nodiscard]] absl::Status RequireComplete(const MatrixView& matrix);

/// The meshes that are left when the one with most missing pairs (of several, the last) is taken
/// away until no pair is missing; ascending. All if none is missing.
[[nodiscard]] std::vector<int64_t> CompleteMeshes(const MatrixView& matrix);

/// Rows and columns of `meshes`, in their order.
[[nodiscard]] MetricMatrix PartOf(const MatrixView& matrix, const std::vector<int64_t>& meshes);

/// Values of a symmetric matrix below the diagonal, row by row: (1,0), (2,0), (2,1), ...
[[nodiscard]] std::vector<double> LowerTriangle(const RowMajorMatrix& values);

}  // namespace cohort
