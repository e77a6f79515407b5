#include "server/planning/batch_partition.h"

#include <string>
#include <vector>

#include <absl/strings/str_join.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

std::string SizesOf(const BatchPartition& partition) {
  std::vector<int64_t> sizes;
  for (int64_t i = 0; i < partition.Count(); ++i) {
    const MeshRange range = partition.At(i);
    sizes.push_back(range.end - range.begin);
  }
  return absl::StrJoin(sizes, " ");
}

TEST(BatchPartitionTest, ShrinksTowardsTheEnd) {
  EXPECT_EQ(SizesOf({60, 6, 2}), "6 6 6 6 6 6 6 5 4 3 2 2 2");
  EXPECT_EQ(SizesOf({60, 6, 1}), "6 6 6 6 6 6 6 5 4 3 2 1 1 1 1");
  EXPECT_EQ(SizesOf({20, 3, 3}), "3 3 3 3 3 3 2");
  EXPECT_EQ(SizesOf({4, 1, 1}), "1 1 1 1");
  EXPECT_EQ(SizesOf({1, 16, 2}), "1");
  EXPECT_EQ(SizesOf({0, 4, 1}), "");
}

TEST(BatchPartitionTest, EveryMeshIsInOneBatchOfNoMoreThanItsShare) {
  for (int64_t meshes = 0; meshes <= 400; ++meshes) {
    for (const int64_t size : {1, 2, 5, 16}) {
      for (int64_t least = 1; least <= size; least += 3) {
        const BatchPartition partition(meshes, size, least);
        int64_t end = 0;
        for (int64_t i = 0; i < partition.Count(); ++i) {
          const MeshRange range = partition.At(i);
          const int64_t left = meshes - range.begin;
          ASSERT_EQ(range.begin, end);
          ASSERT_GT(range.end, range.begin);
          ASSERT_LE(range.end - range.begin, std::min(size, std::max(least, (left + 3) / 4)))
              << meshes << " meshes, size " << size << ", least " << least << ", batch " << i;
          ASSERT_TRUE(range.end - range.begin >= least || range.end == meshes);
          end = range.end;
        }
        ASSERT_EQ(end, meshes);
      }
    }
  }
}

TEST(BatchPartitionTest, AMillionMeshesAreCutAtOnce) {
  const BatchPartition partition(1'000'000, 16, 4);
  EXPECT_EQ(partition.At(0), (MeshRange{.begin = 0, .end = 16}));
  EXPECT_EQ(partition.At(partition.Count() - 1).end, 1'000'000);
  EXPECT_NEAR(static_cast<double>(partition.Count()), 1e6 / 16, 20);
}

TEST(BatchesOfTest, AreWorthHandingOutButEnoughForTenWorkers) {
  EXPECT_EQ(SizesOf(BatchesOf(60, 20'000)), "6 6 6 6 6 6 6 5 4 3 2 1 1 1 1");
  EXPECT_EQ(BatchesOf(60, 700'000).At(0).end, 1) << "each is a quarter of a second";
  EXPECT_EQ(BatchesOf(8, 5'000).Count(), 8);
  EXPECT_EQ(BatchesOf(200, 20'000).At(0).end, 7) << "7 x 8 ms are enough";
  EXPECT_EQ(BatchesOf(200, 1'000).At(0).end, 16) << "the most";
  EXPECT_EQ(BatchesOf(1'100, 700'000).At(0).end, 16) << "more than 64 are not needed";
}

}  // namespace
}  // namespace cohort
