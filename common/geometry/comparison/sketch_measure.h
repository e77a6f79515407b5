#pragma once

#include <absl/status/statusor.h>

#include "common/geometry/comparison/distance_sketch.h"
#include "common/geometry/comparison/measure_field.h"

namespace cohort {

/// What a sketch says of its field, and how far each number can be from the true one:
/// |value - true| <= bound, always, whatever the distribution. Bound and value are NaN where the
/// true value is (geometric mean of signed values).
struct SketchMeasure {
  FieldMeasure value;
  MetricValues bounds{};
  double percentile_bound = 0;
};

/// Answers from a sketch what MeasureField answers from the field.
///
/// Without thresholds and with the sketch's own sign all metrics but the percentiles are exact
/// (bound 0: the same bits). A percentile lies in one bin: the value is interpolated by rank, the
/// bound is at most the bin's width (the extremes are exact). Under thresholds only the bins that
/// are cut off are uncertain, each by its width: sums are known from the exact total less what is
/// cut off, and from the bins that are left, whichever is tighter; RMS and variance also because
/// moving every value by at most e changes RMS and standard deviation by at most e.
/// Absolute values of a signed sketch are answered with the two halves folded.
/// Bounds leave out rounding in double, some 1e-13 of the value.
/// @return kInvalidArgument for the options; kFailedPrecondition if signed values are asked of
///         an absolute sketch, or if the thresholds leave none.
/// Source: ours.
[[nodiscard]] absl::StatusOr<SketchMeasure> MeasureSketch(const DistanceSketch& sketch,
                                                          const FieldOptions& options);

}  // namespace cohort
