#pragma once

#include <cstdint>
#include <utility>

namespace cohort {

/// Unordered pairs of `blocks` blocks, each block with itself too.
[[nodiscard]] inline int64_t BlockPairCount(int64_t blocks) {
  return blocks * (blocks + 1) / 2;
}

/// The pair at `place` of them, as {row, column} with row <= column: column by column those of two
/// blocks, (0,1) (0,2) (1,2) (0,3) ..., then (0,0) (1,1) ... Those of one block are half as much
/// work, those of small last blocks less: what comes late is small, so that workers end together.
[[nodiscard]] std::pair<int64_t, int64_t> BlockPairAt(int64_t blocks, int64_t place);

}  // namespace cohort
