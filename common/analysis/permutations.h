#pragma once

#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "common/base/executor.h"
#include "common/base/random.h"

namespace cohort {

/// For statistics whose sums may differ in the last digits with the order; vegan's value.
inline constexpr double kPermutationTolerance = 1.490116119384766e-08;

/// How many of `count` random orders of N meshes are as extreme as the one found. Order i depends
/// on seed and i only.
/// @param is_as_extreme  called at once from the executor's threads.
[[nodiscard]] inline int64_t CountExtremeOrders(
    int64_t meshes,
    int64_t count,
    uint64_t seed,
    const std::function<bool(const std::vector<int32_t>& order)>& is_as_extreme,
    Executor& executor) {
  Random seeds(seed);
  std::vector<uint64_t> seed_of(static_cast<size_t>(count));
  for (uint64_t& each : seed_of) {
    each = seeds.NextBits();
  }
  std::vector<char> extreme(seed_of.size());
  executor.ParallelFor(count, [&](int64_t i) {
    Random random(seed_of[static_cast<size_t>(i)]);
    std::vector<int32_t> order(static_cast<size_t>(meshes));
    std::iota(order.begin(), order.end(), 0);
    for (int64_t last = meshes - 1; last > 0; --last) {
      std::swap(order[static_cast<size_t>(last)],
                order[static_cast<size_t>(random.Below(last + 1))]);
    }
    extreme[static_cast<size_t>(i)] = is_as_extreme(order) ? 1 : 0;
  });
  return std::accumulate(extreme.begin(), extreme.end(), int64_t{0});
}

}  // namespace cohort
