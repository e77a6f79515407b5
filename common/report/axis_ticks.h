#pragma once

#include <string>
#include <vector>

namespace cohort {

/// Numbers to mark on an axis: all multiples of `step` in the axis's range.
struct AxisTicks {
  double step = 1;             ///< 1, 2 or 5 times a power of ten.
  std::vector<double> values;  ///< Ascending.

  /// The tick as text, with as many decimals as the step needs, or in powers of ten if it is huge
  /// or tiny.
  [[nodiscard]] std::string Text(double value) const;
};

/// Smallest of 1, 2, 5 times a power of ten that is at least `value` (> 0, finite).
[[nodiscard]] double NiceStep(double value);

/// At most about `max_count` (>= 2) ticks at nice numbers in [low, high], low < high.
[[nodiscard]] AxisTicks NiceTicks(double low, double high, int max_count);

}  // namespace cohort
