#include "common/geometry/comparison/order_statistic.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/comparison/fields.h"

namespace cohort {
namespace {

TEST(PercentileRank, IsThePredecessorsForTheThirdQuartile) {
  EXPECT_EQ(PercentileRank(10000, 0.75), 7499);
  EXPECT_EQ(PercentileRank(4, 0.75), 2);
  EXPECT_EQ(PercentileRank(1, 0.75), 0);
}

TEST(PercentileRank, StaysWithinTheValues) {
  EXPECT_EQ(PercentileRank(10, 0), 0);
  EXPECT_EQ(PercentileRank(10, 1), 9);
  EXPECT_EQ(PercentileRank(1, 0), 0);
  EXPECT_EQ(PercentileRank(1, 1), 0);
}

class SelectRankOf : public ::testing::TestWithParam<int> {};

TEST_P(SelectRankOf, IsTheSortedValueForEveryDistributionAndRank) {
  const int n = GetParam();
  for (const auto& [name, field] : testing::SignedFields(n)) {
    std::vector<float> sorted = field;
    std::sort(sorted.begin(), sorted.end());
    for (const int rank : {0, 1, n / 4, n / 2, 3 * n / 4, n - 2, n - 1}) {
      if (rank >= 0 && rank < n) {
        std::vector<float> scratch = field;
        EXPECT_EQ(SelectRank(scratch, rank), sorted.at(static_cast<size_t>(rank)))
            << name << " " << rank;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Sizes, SelectRankOf, ::testing::Values(1, 2, 17, 1024, 1025, 20000));

TEST(SelectRank, CountsMinusZeroAsZero) {
  std::vector<float> values = {-0.0F, 1, 0.0F};
  const float zero = SelectRank(values, 0);
  EXPECT_EQ(zero, 0);
  EXPECT_FALSE(std::signbit(zero));
}

}  // namespace
}  // namespace cohort
