#include "server/planning/block_pairs.h"

#include <cmath>

namespace cohort {

std::pair<int64_t, int64_t> BlockPairAt(int64_t blocks, int64_t place) {
  const int64_t of_two = BlockPairCount(blocks - 1);
  if (place >= of_two) {
    return {place - of_two, place - of_two};
  }
  // Columns 1, 2, 3, ... have 1, 2, 3, ... pairs.
  auto column = static_cast<int64_t>((std::sqrt(8 * static_cast<double>(place) + 1) + 1) / 2);
  while (BlockPairCount(column - 1) > place) {
    --column;
  }
  while (BlockPairCount(column) <= place) {
    ++column;
  }
  return {place - BlockPairCount(column - 1), column};
}

}  // namespace cohort
