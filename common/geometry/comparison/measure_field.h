#pragma once

#include <cstdint>
#include <span>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/comparison/metrics.h"

namespace cohort {

/// What to ask of a distance field.
struct FieldOptions {
  /// kAbsolute takes |d| of every value first; kSigned wants signed values.
  DistanceSign sign = DistanceSign::kAbsolute;
  double percentile = 0.75;  ///< Share in [0, 1] of FieldMeasure::percentile.
  /// Shares in [0, 1] of the sorted values: which of them count. 0 and 1: all. upper <= lower: the
  /// single value 0. Else those of the ranks PercentileRank(n, lower) up to and without
  /// PercentileRank(n, upper): upper = 1 with lower > 0 loses the largest value.
  /// Source: the predecessor (reference c7).
  double lower_share = 0;
  double upper_share = 1;

  [[nodiscard]] bool HasThresholds() const { return lower_share > 0 || upper_share < 1; }
  /// @return kInvalidArgument if a share is outside [0, 1].
  [[nodiscard]] absl::Status Validate() const;
};

/// The answer. Of signed values min and max are algebraic, the geometric mean is NaN if a value is
/// negative, and the percentiles are absolute values of the percentile of the signed values.
struct FieldMeasure {
  MetricValues metrics{};  ///< kPercentile75 is the 75th whatever FieldOptions::percentile is.
  double percentile = 0;   ///< Of rank PercentileRank(n, FieldOptions::percentile).
  int64_t count = 0;       ///< Values that count: after thresholds and zero weights.
};

/// Metrics of a field under options; without thresholds the same bits as MeasureDistances.
///
/// Under thresholds sums run over the values strictly between the two at the ends in index order,
/// then over those equal to the lower and the upper one.
/// @param distances  n values, mesh units.
/// @return kInvalidArgument if there is none or one is not finite, or for the options;
///         kFailedPrecondition if the thresholds leave none.
[[nodiscard]] absl::StatusOr<FieldMeasure> MeasureField(std::span<const float> distances,
                                                        const FieldOptions& options);

/// The same where value i counts w_i: vertex areas make the metrics independent of the density of
/// vertices, a weight of 0 leaves a vertex out (region masks).
///
/// With W = sum w over the values that count:
///   mean = sum w d / W, RMS = sqrt(sum w d^2 / W), variance = sum w (d - mean)^2 / W,
///   geometric mean = exp(sum w ln d / W), min and max over w > 0;
///   percentile q: in ascending order (ties by index) the last value with
///   (weight before it + w / 2) / W <= q, or the first of all.
/// Thresholds cut at the percentiles of their shares as they do unweighted. Equal weights that are
/// powers of two give the ranks of MeasureField. Sums run in ascending order of the values.
/// @param weights  n values >= 0, finite.
/// @return as MeasureField; kInvalidArgument for weights that are not; kFailedPrecondition if all
///         are 0.
/// Source: ours; the percentile rule is PercentileRank's, written with weights.
[[nodiscard]] absl::StatusOr<FieldMeasure> MeasureWeightedField(std::span<const float> distances,
                                                                std::span<const double> weights,
                                                                const FieldOptions& options);

}  // namespace cohort
