#pragma once

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace cohort {

/// Which pairs of a query and its nearest neighbour count.
struct PairMask {
  std::vector<uint8_t> keep;  ///< n flags, 1 or 0.
  int64_t kept = 0;           ///< How many are 1.
};

/// Drops the pairs whose neighbour lies on the target's open boundary: there the nearest vertex is
/// that of the rim only because the surface ends.
/// @param nearest  n indices below the size of `target_boundary`.
/// @param target_boundary  One flag per vertex of the target (BoundaryVertices).
[[nodiscard]] PairMask RejectBoundaryPairs(std::span<const int32_t> nearest,
                                           std::span<const uint8_t> target_boundary);

/// The values (distances, weights, ...) of the pairs that count, in order: mask.kept of them, which
/// may be none.
template <typename T>
[[nodiscard]] std::vector<T> KeptValues(std::span<const T> values, const PairMask& mask) {
  assert(values.size() == mask.keep.size());
  std::vector<T> kept;
  kept.reserve(static_cast<size_t>(mask.kept));
  for (size_t i = 0; i < values.size(); ++i) {
    if (mask.keep[i] != 0) {
      kept.push_back(values[i]);
    }
  }
  return kept;
}

}  // namespace cohort
