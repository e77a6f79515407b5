#pragma once

#include <cstdint>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/report/quantiles.h"

namespace cohort {

/// What a heat map shows of a matrix: at most some cells a side, and which numbers get which
/// colours.
struct MatrixPicture {
  int side = 0;
  std::vector<double> values;  ///< side x side, row by row; NaN: nothing measured there.
  bool shows_diagonal = true;  ///< A cell is one pair, so the diagonal is a line of cells.
  int64_t missing = 0;         ///< NaN off the diagonal of the matrix.
  double smallest = 0;         ///< Off the diagonal of the matrix; 0 if nothing was measured.
  double largest = 0;
  ValueRange range;           ///< low < high.
  bool clipped_high = false;  ///< `largest` lies beyond the range.

  [[nodiscard]] double At(int row, int column) const {
    return values[static_cast<size_t>(row) * static_cast<size_t>(side) +
                  static_cast<size_t>(column)];
  }
};

/// Means over blocks of entries off the diagonal, NaN left out, if the matrix has more than
/// `max_side` rows; its entries otherwise.
/// @param values  N x N, N >= 1.
[[nodiscard]] MatrixPicture MakeMatrixPicture(const Eigen::Ref<const RowMajorMatrix>& values,
                                              int max_side);

/// `range`, widened about its middle if it is empty or too narrow to put ticks on.
[[nodiscard]] ValueRange UsableRange(const ValueRange& range);

}  // namespace cohort
