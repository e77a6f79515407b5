#include "common/geometry/comparison/stable_log.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A few units in the last place.
constexpr double kRounding = 8e-16;

TEST(StableLog, AgreesWithTheLibraryOverAllMagnitudes) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double x = std::ldexp(random.Uniform(1, 2), static_cast<int>(random.Below(2000)) - 1000);
    const double expected = std::log(x);
    EXPECT_NEAR(StableLog(x), expected, kRounding * std::max(1.0, std::abs(expected))) << x;
  }
}

TEST(StableLog, KeepsItsPrecisionNearOne) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double x = 1 + random.Uniform(-1e-3, 1e-3);
    EXPECT_NEAR(StableLog(x), std::log(x), kRounding * std::abs(std::log(x))) << x;
  }
  EXPECT_EQ(StableLog(1), 0);
}

TEST(StableLog, OfZeroIsMinusInfinityAndOfSubnormalsIsFinite) {
  EXPECT_EQ(StableLog(0), -kInfinity);
  EXPECT_NEAR(StableLog(5e-324), std::log(5e-324), 1e-12);
}

TEST(StableExp, AgreesWithTheLibrary) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double x = random.Uniform(-700, 700);
    EXPECT_NEAR(StableExp(x) / std::exp(x), 1, kRounding) << x;
  }
  EXPECT_EQ(StableExp(0), 1);
}

TEST(StableExp, EndsWhereDoublesDo) {
  EXPECT_EQ(StableExp(-kInfinity), 0);
  EXPECT_EQ(StableExp(-746), 0);
  EXPECT_EQ(StableExp(710), kInfinity);
}

TEST(StableExp, InvertsStableLog) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.Uniform(0.001, 100);
    EXPECT_NEAR(StableExp(StableLog(x)) / x, 1, 2 * kRounding) << x;
  }
}

TEST(StableLog, HasTheBitsItHadWhenItWasWritten) {
  EXPECT_EQ(StableLog(2.5), 0x1.d5240f0e0e078p-1);
  EXPECT_EQ(StableExp(0.7), 0x1.01c2a61268987p+1);
}

}  // namespace
}  // namespace cohort
