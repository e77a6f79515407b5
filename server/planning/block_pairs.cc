#include "server/planning/block_pairs.h"

#include <cmath>

namespace cohort {

std::pair<int64_t, int64_t> BlockPairAt(int64_t blocks, int64_t place) {
  const int64_t of_two = BlockPairCount(blocks - 1);
  if (place >= of_two) {
    return {place - of_two, place - of_two};
  }
  // Counted from the end, rows have 1, 2, 3, ... pairs.
  const int64_t from_end = of_two - 1 - place;
  auto row_from_end =
      static_cast<int64_t>((std::sqrt(8 * static_cast<double>(from_end) + 1) - 1) / 2);
  while (row_from_end * (row_from_end + 1) / 2 > from_end) {
    --row_from_end;
  }
  while ((row_from_end + 1) * (row_from_end + 2) / 2 <= from_end) {
    ++row_from_end;
  }
  const int64_t column_from_end = from_end - row_from_end * (row_from_end + 1) / 2;
  return {blocks - 2 - row_from_end, blocks - 1 - column_from_end};
}

}  // namespace cohort
