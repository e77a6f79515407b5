#include "common/report/quantiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace cohort {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> CountTo(int count) {
  std::vector<double> values;
  for (int i = 0; i <= count; ++i) values.push_back((i * 37) % (count + 1));
  return values;
}

TEST(QuantileRange, TakesTheNearestRank) {
  const ValueRange range = QuantileRange(CountTo(100), 0.02, 0.98);
  EXPECT_EQ(range.low, 2);
  EXPECT_EQ(range.high, 98);
}

TEST(QuantileRange, LeavesOutMissingValues) {
  const std::vector<double> values = {kNaN, 5, kNaN, 3};
  const ValueRange range = QuantileRange(values, 0, 1);
  EXPECT_EQ(range.low, 3);
  EXPECT_EQ(range.high, 5);
}

TEST(QuantileRange, OfNothingIsZeroToOne) {
  const ValueRange range = QuantileRange(std::vector<double>{kNaN}, 0.1, 0.9);
  EXPECT_EQ(range.low, 0);
  EXPECT_EQ(range.high, 1);
}

TEST(ValueRange, PositionsRunFromZeroToOne) {
  const ValueRange range = {2, 4};
  EXPECT_EQ(range.Position(2), 0);
  EXPECT_EQ(range.Position(3.5), 0.75);
  EXPECT_TRUE(std::isnan(range.Position(kNaN)));
  EXPECT_EQ((ValueRange{3, 3}.Position(3)), 0.5);
}

TEST(FarFence, StandsFourQuartileRangesAboveTheThirdQuartile) {
  std::vector<double> values = CountTo(100);
  EXPECT_FALSE(FarFence(values).has_value());
  values[0] = 1000;  // Was 0: the quartiles become 26 and 76.
  EXPECT_EQ(FarFence(values), 76 + 4 * (76 - 26));
}

TEST(FarFence, NeedsEnoughValuesThatDiffer) {
  EXPECT_FALSE(FarFence(std::vector<double>{1, 2, 3, 1000}).has_value());
  std::vector<double> values(100, 1.0);
  values[0] = 1000;
  EXPECT_FALSE(FarFence(values).has_value());
}

TEST(FarFence, OfSortedValuesIsTheSame) {
  for (const int count : {0, 5, 20, 101}) {
    std::vector<double> values = CountTo(count);
    for (const double far : {50.0, 1e6}) {
      values.back() = far;
      std::sort(values.begin(), values.end());
      EXPECT_EQ(FarFenceOfSorted(values), FarFence(values)) << count << " to " << far;
    }
  }
  EXPECT_FALSE(FarFenceOfSorted({}).has_value());
}

}  // namespace
}  // namespace cohort
