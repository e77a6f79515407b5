#include "server/core/task_rates.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;

TEST(TaskRates, AreUnknownUntilATaskWasDone) {
  TaskRates rates;
  EXPECT_EQ(rates.RateOf("align"), std::nullopt);
  rates.Note("align", 0, 5);
  EXPECT_EQ(rates.RateOf("align"), std::nullopt) << "a task that costs nothing tells nothing";
  rates.Note("align", 2, 5);
  EXPECT_THAT(rates.RateOf("align"), Optional(DoubleNear(2.5, 1e-12)));
  EXPECT_EQ(rates.RateOf("compare"), std::nullopt);
}

TEST(TaskRates, WeighLongTasksMoreAndForgetOldOnes) {
  TaskRates rates;
  rates.Note("a", 0.001, 1);  // Mostly overhead.
  rates.Note("a", 100, 100);
  EXPECT_THAT(rates.RateOf("a"), Optional(DoubleNear(1.01, 0.001)));
  for (int i = 0; i < 2000; ++i) {
    rates.Note("a", 1, 4);  // Another machine.
  }
  EXPECT_THAT(rates.RateOf("a"), Optional(DoubleNear(4, 0.01)));
}

TEST(TaskRates, TellKindsApartThatCostDifferently) {
  JobSpec spec;
  EXPECT_EQ(TaskRates::KindOf(spec, "align 1"), TaskRates::KindOf(spec, "align 3"));
  EXPECT_NE(TaskRates::KindOf(spec, "align 1"), TaskRates::KindOf(spec, "compare"));
  JobSpec other = spec;
  other.method = Method::kEach;
  EXPECT_NE(TaskRates::KindOf(other, "compare"), TaskRates::KindOf(spec, "compare"));
  other = spec;
  other.compare.correspondence = Correspondence::kSurface;
  EXPECT_NE(TaskRates::KindOf(other, "compare"), TaskRates::KindOf(spec, "compare"));
  EXPECT_EQ(TaskRates::KindOf(other, "align 1"), TaskRates::KindOf(spec, "align 1"));
  other = spec;
  other.icp.acceleration = Acceleration::kNone;
  EXPECT_NE(TaskRates::KindOf(other, "align 1"), TaskRates::KindOf(spec, "align 1"));
}

}  // namespace
}  // namespace cohort
