#include "common/report/axis_ticks.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Texts(const AxisTicks& ticks) {
  std::vector<std::string> texts;
  for (const double value : ticks.values) texts.push_back(ticks.Text(value));
  return texts;
}

TEST(NiceStep, IsTheNextOfOneTwoFive) {
  EXPECT_EQ(NiceStep(1), 1);
  EXPECT_EQ(NiceStep(1.1), 2);
  EXPECT_EQ(NiceStep(3), 5);
  EXPECT_EQ(NiceStep(7), 10);
  EXPECT_EQ(NiceStep(0.013), 0.02);
  EXPECT_EQ(NiceStep(0.1), 0.1);
}

TEST(NiceTicks, AreMultiplesOfTheStepWithinTheRange) {
  EXPECT_THAT(Texts(NiceTicks(0.37, 1.93, 9)),
              ElementsAre("0.4", "0.6", "0.8", "1.0", "1.2", "1.4", "1.6", "1.8"));
}

TEST(NiceTicks, IncludeBoundsThatAreTicks) {
  EXPECT_THAT(Texts(NiceTicks(0, 1, 6)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(Texts(NiceTicks(-10, 10, 5)), ElementsAre("-10", "-5", "0", "5", "10"));
}

TEST(NiceTicks, WriteTinyAndHugeNumbersShortly) {
  EXPECT_THAT(Texts(NiceTicks(0, 4e-6, 3)), ElementsAre("0", "2e-06", "4e-06"));
  EXPECT_THAT(Texts(NiceTicks(0, 4e7, 3)), ElementsAre("0", "2e+07", "4e+07"));
}

TEST(NiceTicks, AreFewForAnyRange) {
  EXPECT_LE(NiceTicks(1e9, 1e9 + 1, 5).values.size(), 5U);
  EXPECT_LE(NiceTicks(0.123, 987.6, 5).values.size(), 5U);
}

}  // namespace
}  // namespace cohort
