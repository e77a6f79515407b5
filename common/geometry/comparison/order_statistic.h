#pragma once

#include <cstdint>
#include <span>

namespace cohort {

/// 0-based rank, ascending, of the percentile q in [0, 1] of n >= 1 values: trunc(q n - 0.5), at
/// least 0 and at most n - 1. No interpolation.
/// Source: the predecessor (reference c7), for q = 0.75.
[[nodiscard]] int64_t PercentileRank(int64_t count, double q);

/// The value of the given rank (0-based, ascending): exactly that of the sorted values, in linear
/// time whatever their distribution. Reorders and overwrites `values`; -0 counts as 0.
/// By histograms of 12, 12 and 8 bits of the float's ordered bits, of the values still in question.
[[nodiscard]] float SelectRank(std::span<float> values, int64_t rank);

}  // namespace cohort
