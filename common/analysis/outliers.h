#pragma once

#include <span>
#include <vector>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// A robust z above this is an outlier. Source: Iglewicz, Hoaglin 1993.
inline constexpr double kOutlierZ = 3.5;

/// How far each value is from the median, in robust standard deviations: 0.6745 (x - median) / MAD,
/// with MAD the median of |x - median|. If MAD is zero (over half of the values equal), the mean of
/// |x - median| times 1.2533 stands for MAD / 0.6745; if that is zero too, all are 0. NaN is left
/// out and stays NaN; under 3 values: all NaN.
/// Source: Iglewicz, Hoaglin 1993.
[[nodiscard]] std::vector<double> RobustZ(std::span<const double> values);

/// Mean of each row without the diagonal and what is missing; NaN where nothing is left.
[[nodiscard]] std::vector<double> MeanDistances(const MetricMatrix& matrix);

/// Median with the mean of the middle two; NaN is left out, NaN if nothing is left.
[[nodiscard]] double MedianOf(std::span<const double> values);

}  // namespace cohort
