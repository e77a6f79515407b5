#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/comparison/distance_sketch.h"
#include "common/geometry/comparison/metrics.h"

namespace cohort {

/// Everything the hot path keeps of one directed pair.
struct DistanceSummary {
  MetricValues metrics{};
  DistanceSketch sketch;
};

/// Memory that is reused from pair to pair. Not thread-safe.
struct DistanceScratch {
  /// The distances that were measured last: what retention encodes.
  std::vector<float> distances;
  std::vector<float> candidates;
};

/// All metrics and the sketch of a field of squared distances (n >= 1, finite, >= 0), in about
/// 1 ns a value; its float32 roots are left in scratch.distances.
///
/// Three passes in the fastest cache: roots, sums, extremes and the product for the geometric mean;
/// the histogram; the values of the one bin that holds the percentile. Same bits on every
/// instruction set (see ComputeMetrics).
[[nodiscard]] DistanceSummary MeasureSquaredDistances(std::span<const float> squared_distances,
                                                      DistanceScratch& scratch);

/// The same for distances as kept, so that metrics computed again are the first ones; signed ones
/// give signed metrics: algebraic min and max, P75 as the absolute value of the percentile of the
/// signed values, geometric mean NaN if a value is negative.
/// @param distances  n >= 1, finite; for kAbsolute >= 0. May not lie in `scratch`.
[[nodiscard]] DistanceSummary MeasureDistances(std::span<const float> distances,
                                               DistanceSign sign,
                                               DistanceScratch& scratch);

/// The value of rank PercentileRank(n, q) of the field, exactly; signed if the field is.
/// @param distances  Those that `sketch` was made of.
[[nodiscard]] float SelectPercentile(std::span<const float> distances,
                                     const DistanceSketch& sketch,
                                     double q,
                                     DistanceScratch& scratch);

/// The passes with given kernels, for tests that compare instruction sets.
[[nodiscard]] DistanceSummary MeasureWith(const FieldKernels& kernels,
                                          FieldInput input,
                                          std::span<const float> values,
                                          DistanceScratch& scratch);

}  // namespace cohort
