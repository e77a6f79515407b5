#include "common/geometry/comparison/pair_mask.h"

namespace cohort {

PairMask RejectBoundaryPairs(std::span<const int32_t> nearest,
                             std::span<const uint8_t> target_boundary) {
  PairMask mask;
  mask.keep.reserve(nearest.size());
  for (const int32_t vertex : nearest) {
    assert(vertex >= 0 && static_cast<size_t>(vertex) < target_boundary.size());
    const uint8_t keep = target_boundary[static_cast<size_t>(vertex)] == 0 ? 1 : 0;
    mask.keep.push_back(keep);
    mask.kept += keep;
  }
  return mask;
}

}  // namespace cohort
