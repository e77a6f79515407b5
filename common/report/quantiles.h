#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace cohort {

/// From `low` to `high`.
struct ValueRange {
  double low = 0;
  double high = 1;

  /// low -> 0, high -> 1; 0.5 if low equals high; NaN stays NaN.
  [[nodiscard]] double Position(double value) const;
};

/// The `low_share` and `high_share` quantiles (0..1, nearest rank) of the values that are not NaN;
/// [0, 1] if there is none. The order of the values has no influence.
[[nodiscard]] ValueRange QuantileRange(std::span<const double> values,
                                       double low_share,
                                       double high_share);

/// Third quartile + 4 interquartile ranges, if a value lies beyond it: what is there (a mesh whose
/// alignment failed) would otherwise make all others look the same. Empty if none does, or there
/// are too few values (under 8) to tell.
/// Source: Tukey 1977, the idea of fences; his factors are 1.5 and 3.
[[nodiscard]] std::optional<double> FarFence(std::span<const double> values);
/// The same of ascending values without NaN.
[[nodiscard]] std::optional<double> FarFenceOfSorted(std::span<const double> values);

/// Which of `count` ascending values (count >= 1) is the quantile `share` (0..1, nearest rank).
[[nodiscard]] size_t QuantileRank(size_t count, double share);

}  // namespace cohort
