#include "common/base/random.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace cohort {
namespace {

// Expected values: the published output of SplitMix64 for the seed 1234567 (Rosetta Code).
TEST(Random, GivesTheNumbersOfSplitMix64) {
  Random random(1234567);
  std::vector<uint64_t> numbers;
  numbers.reserve(5);
  for (int i = 0; i < 5; ++i) {
    numbers.push_back(random.NextBits());
  }

  EXPECT_EQ(numbers,
            (std::vector<uint64_t>{6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                   4593380528125082431u, 16408922859458223821u}));
}

// The standard error of a mean of n uniform numbers is sqrt(1 / 12 n): the tolerance is 5 of them.
TEST(Random, UniformFillsItsRangeEvenly) {
  constexpr int kCount = 100'000;
  Random random(1);
  double sum = 0;
  double lowest = 10;
  double highest = -10;
  for (int i = 0; i < kCount; ++i) {
    const double value = random.Uniform(-2, 3);
    sum += value;
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }

  EXPECT_NEAR(sum / kCount, 0.5, 5 * 5 * std::sqrt(1.0 / (12 * kCount)));
  EXPECT_GE(lowest, -2);
  EXPECT_LT(highest, 3);
}

// Each of 7 counts is binomial with deviation below sqrt(n / 7): the tolerance is 5 of them.
TEST(Random, BelowGivesEachIntegerEquallyOften) {
  constexpr int kCount = 70'000;
  Random random(2);
  std::vector<int> counts(7);
  for (int i = 0; i < kCount; ++i) {
    ++counts.at(static_cast<size_t>(random.Below(7)));
  }

  for (const int count : counts) {
    EXPECT_NEAR(count, kCount / 7.0, 5 * std::sqrt(kCount / 7.0)) << count;
  }
}

// Standard errors: 1 / sqrt(n) of the mean, sqrt(2 / n) of the variance; the tolerances are 5.
TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  constexpr int kCount = 100'000;
  Random random(3);
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double value = random.Normal();
    sum += value;
    squares += value * value;
  }

  EXPECT_NEAR(sum / kCount, 0, 5 / std::sqrt(kCount));
  EXPECT_NEAR(squares / kCount, 1, 5 * std::sqrt(2.0 / kCount));
}

}  // namespace
}  // namespace cohort
