#pragma once

#include <span>
#include <string>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// The matrix as a NumPy file: numpy.load gives an N x N array of float64, row = source.
///
/// Version 1.0, '<f8', C order, data from a multiple of 64 bytes on; the same bytes on any machine.
/// Source: numpy.lib.format, "Format Version 1.0".
[[nodiscard]] std::string MatrixNpy(const Eigen::Ref<const RowMajorMatrix>& values);
/// Its beginning; the values follow row by row, as they lie in memory.
[[nodiscard]] std::string NpyHeader(Eigen::Index rows, Eigen::Index columns);

/// One label per line (LF), in the matrix's order. File names hold no line breaks; should a label
/// hold one, it becomes a space, so that line i is always mesh i.
[[nodiscard]] std::string LabelsText(std::span<const std::string> labels);

}  // namespace cohort
