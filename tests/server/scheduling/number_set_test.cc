#include "server/scheduling/number_set.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "server/scheduling/duration_histogram.h"

namespace cohort {
namespace {

TEST(NumberSet, IsTheSetOfWhatWasPutIn) {
  Random random(1);
  NumberSet numbers;
  std::set<int64_t> truth;
  for (int step = 0; step < 20'000; ++step) {
    const int64_t number = random.Below(60);
    switch (random.Below(3)) {
      case 0: {
        const int64_t count = random.Below(8);
        numbers.InsertRange(number, count);
        for (int64_t i = 0; i < count; ++i) {
          truth.insert(number + i);
        }
        break;
      }
      case 1:
        numbers.Erase(number);
        truth.erase(number);
        break;
      default:
        numbers.Insert(number);
        truth.insert(number);
    }
    ASSERT_EQ(numbers.Size(), std::ssize(truth));
    ASSERT_EQ(numbers.Contains(number), truth.contains(number));
    std::vector<int64_t> first;
    numbers.ForEachOfFirst(5, [&](int64_t member) { first.push_back(member); });
    std::vector<int64_t> expected;
    for (const int64_t member : truth) {
      if (expected.size() < 5) {
        expected.push_back(member);
      }
    }
    ASSERT_EQ(first, expected) << "step " << step;
    if (!truth.empty()) {
      ASSERT_EQ(numbers.First(), *truth.begin());
    }
  }
}

TEST(DurationHistogram, KnowsAQuantileToTenPercent) {
  DurationHistogram durations;
  for (int i = 1; i <= 1000; ++i) {
    durations.Add(0.01 * i);
  }
  EXPECT_EQ(durations.Count(), 1000);
  EXPECT_NEAR(durations.Quantile(0.95), 9.5, 0.1 * 9.5);
  EXPECT_NEAR(durations.Quantile(0.5), 5, 0.1 * 5);
  durations.Add(1e30);
  durations.Add(0);
  EXPECT_EQ(DurationHistogram().Quantile(0.5), 0);
}

}  // namespace
}  // namespace cohort
