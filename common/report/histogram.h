#pragma once

#include <span>
#include <string>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"
#include "common/report/matrix_description.h"

namespace cohort {

/// Distribution of the values off the diagonal (PNG). Each pair counts once; in a directed matrix
/// both directions count.
///
/// With persons: two distributions, "same person" and "different people", as shares of their own
/// pairs, since the second has many more. Medians are dashed lines; the legend has the counts.
/// @param persons  one per mesh, "" for unknown (PersonsOf); or none. Pairs with an unknown person
///        are left out, which the picture says, unless nobody is known.
/// @return kInvalidArgument if the sizes of labels, values and persons differ; kInternal if cairo
///         fails.
[[nodiscard]] absl::StatusOr<std::string> HistogramPng(const MatrixView& matrix,
                                                       const MatrixDescription& description,
                                                       std::span<const std::string> persons);

}  // namespace cohort
