#include "server/planning/block_partition.h"

#include <algorithm>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>

#include "server/planning/block_pairs.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;

std::vector<int64_t> SizesOf(const BlockPartition& blocks) {
  std::vector<int64_t> sizes;
  for (int64_t block = 0; block < blocks.Count(); ++block) {
    sizes.push_back(blocks.At(block).Size());
  }
  return sizes;
}

TEST(BlockPartition, EndsWithSmallBlocks) {
  EXPECT_THAT(SizesOf(BlockPartition(60, 6)), ElementsAre(14, 13, 13, 10, 7, 3));
  EXPECT_THAT(SizesOf(BlockPartition(11, 4)), ElementsAre(4, 3, 3, 1));
  EXPECT_THAT(SizesOf(BlockPartition(5, 1)), ElementsAre(5));
  EXPECT_THAT(SizesOf(BlockPartition(5, 5)), ElementsAre(1, 1, 1, 1, 1));
}

TEST(BlockPartition, CoversAllMeshesOnceAndKeepsItsBounds) {
  for (int64_t meshes = 1; meshes < 150; ++meshes) {
    for (int64_t count = 1; count <= meshes; ++count) {
      SCOPED_TRACE(absl::StrCat(meshes, " meshes in ", count, " blocks"));
      const BlockPartition blocks(meshes, count);
      const std::vector<int64_t> sizes = SizesOf(blocks);
      int64_t end = 0;
      for (int64_t block = 0; block < count; ++block) {
        ASSERT_EQ(blocks.At(block).begin, end);
        end = blocks.At(block).end;
        if (block > 0) {  // Rounding lets one of equal weight have one mesh more.
          ASSERT_LE(sizes[static_cast<size_t>(block)], sizes[static_cast<size_t>(block) - 1] + 1);
        }
      }
      ASSERT_EQ(end, meshes);
      ASSERT_GE(*std::min_element(sizes.begin(), sizes.end()), 1);
      ASSERT_LE(*std::max_element(sizes.begin(), sizes.end()), blocks.MostMeshes());
      ASSERT_LE(blocks.MostMeshes(), 2 * (meshes + count - 1) / count);
    }
  }
}

TEST(BlockPartition, OfNoMeshesHasNoBlocks) {
  const BlockPartition blocks(0, 0);
  EXPECT_EQ(blocks.Count(), 0);
  EXPECT_EQ(blocks.MostMeshes(), 0);
}

TEST(BlockPartition, HoldsAHundredThousandMeshes) {
  const BlockPartition blocks(100000, 1409);
  EXPECT_EQ(blocks.At(0).begin, 0);
  EXPECT_EQ(blocks.At(1408).end, 100000);
  EXPECT_EQ(blocks.MostMeshes(), 72);
}

TEST(BlockPairs, AreEachThereOnce) {
  for (const int64_t blocks : {1, 2, 3, 7, 100}) {
    std::vector<std::pair<int64_t, int64_t>> expected;
    for (int64_t column = 1; column < blocks; ++column) {
      for (int64_t row = 0; row < column; ++row) {
        expected.emplace_back(row, column);
      }
    }
    for (int64_t block = 0; block < blocks; ++block) {
      expected.emplace_back(block, block);
    }
    std::vector<std::pair<int64_t, int64_t>> pairs;
    for (int64_t place = 0; place < BlockPairCount(blocks); ++place) {
      pairs.push_back(BlockPairAt(blocks, place));
    }
    EXPECT_EQ(pairs, expected);
  }
  const int64_t many = 2'000'000;  // Roots of large numbers are rounded.
  for (const int64_t column : {many / 3, many - 2, many - 1}) {
    const int64_t first = BlockPairCount(column - 1);
    EXPECT_EQ(BlockPairAt(many, first), std::pair(int64_t{0}, column));
    EXPECT_EQ(BlockPairAt(many, first + column - 1), std::pair(column - 1, column));
  }
}

}  // namespace
}  // namespace cohort
