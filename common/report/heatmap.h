#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"
#include "common/report/matrix_description.h"

namespace cohort {

/// The matrix as a picture (PNG): one square per pair with a colour bar, the diagonal in light
/// grey, pairs that were not measured (NaN) in dark grey.
///
/// Up to about 100 meshes have their labels (shortened if long), more have numbers in the matrix's
/// order, from 1; few have their values in the squares. More than 1600 meshes are averaged in
/// blocks, one pixel each. The colours run from the smallest to the largest value off the diagonal;
/// a few values far above all others get the last colour, which the picture says.
/// @return kInvalidArgument if there is no mesh or the sizes of labels and values differ; kInternal
///         if cairo fails.
[[nodiscard]] absl::StatusOr<std::string> HeatmapPng(const MatrixView& matrix,
                                                     const MatrixDescription& description);

}  // namespace cohort
