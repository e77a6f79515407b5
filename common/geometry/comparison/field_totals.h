#pragma once

#include <cstdint>
#include <span>

#include "common/geometry/comparison/metrics.h"

namespace cohort {

/// What one pass over a field of n values d gives exactly (up to rounding in double). For absolute
/// fields the sums and minima of d and |d| are the same.
struct FieldTotals {
  int64_t count = 0;              ///< n
  double sum = 0;                 ///< sum d
  double sum_absolute = 0;        ///< sum |d|
  double sum_squares = 0;         ///< sum d^2
  double squared_deviations = 0;  ///< sum (d - sum / n)^2, in a second pass: no cancellation.
  double log_mean = 0;            ///< sum ln |d| / n; -infinity if some d is 0.
  double min = 0;                 ///< Algebraic.
  double max = 0;                 ///< Algebraic.
  double min_absolute = 0;        ///< min |d|

  friend bool operator==(const FieldTotals&, const FieldTotals&) = default;
};

/// The metrics that follow from the totals; kPercentile75 does not and is 0.
///
/// The means are kept between the extremes and in their order where rounding alone would leave it.
/// The geometric mean is NaN if a value is negative, 0 if a value is 0.
/// Source: reference c7 and (f); its "variance 0 where the mean is 0" is not followed.
[[nodiscard]] MetricValues MetricsOfTotals(const FieldTotals& totals);

/// Mean of the logarithms of n values whose product is the product of mantissa 2^exponent over the
/// lanes; mantissas in [1, 2).
[[nodiscard]] double LogMeanOfProduct(std::span<const double> mantissas,
                                      std::span<const int64_t> exponents,
                                      int64_t count);

}  // namespace cohort
