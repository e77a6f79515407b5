#include "common/report/decimal.h"

#include <limits>

#include <gtest/gtest.h>

namespace cohort {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ShortestDecimal, IsWhatReadsBack) {
  EXPECT_EQ(ShortestDecimal(0.1), "0.1");
  EXPECT_EQ(ShortestDecimal(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(ShortestDecimal(-2), "-2");
  EXPECT_EQ(ShortestDecimal(5e-324), "5e-324");
}

TEST(ShortestDecimal, HasWordsThatRUnderstandsForTheRest) {
  EXPECT_EQ(ShortestDecimal(kNaN), "NA");
  EXPECT_EQ(ShortestDecimal(kInfinity), "Inf");
  EXPECT_EQ(ShortestDecimal(-kInfinity), "-Inf");
}

TEST(FixedDecimal, RoundsAndHasNoMinusBeforeZero) {
  EXPECT_EQ(FixedDecimal(1.005, 1), "1.0");
  EXPECT_EQ(FixedDecimal(-0.001, 2), "0.00");
  EXPECT_EQ(FixedDecimal(-1.26, 1), "-1.3");
  EXPECT_EQ(FixedDecimal(1e300, 0).size(), 301U);
}

TEST(ReadableDecimal, KeepsSignificantDigits) {
  EXPECT_EQ(ReadableDecimal(1.5, 3), "1.50");
  EXPECT_EQ(ReadableDecimal(0.012345, 3), "0.0123");
  EXPECT_EQ(ReadableDecimal(123456, 3), "123456");
  EXPECT_EQ(ReadableDecimal(12345678, 2), "1.2e+07");
  EXPECT_EQ(ReadableDecimal(0, 3), "0");
}

}  // namespace
}  // namespace cohort
