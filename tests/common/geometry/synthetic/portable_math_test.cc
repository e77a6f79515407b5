#include "common/geometry/synthetic/portable_math.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

TEST(PortableExp, AgreesWithTheLibraryToAFewUnits) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const double x = random.Uniform(-60.0, 20.0);
    EXPECT_NEAR(PortableExp(x) / std::exp(x), 1.0, 1e-15) << x;
  }
}

TEST(PortableExp, IsOneAtZeroAndVanishesFarDown) {
  EXPECT_EQ(PortableExp(0.0), 1.0);
  EXPECT_EQ(PortableExp(-1000.0), 0.0);
}

TEST(PortableSin, AgreesWithTheLibraryAsDoesTheCosine) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double angle = random.Uniform(-500.0, 500.0);
    EXPECT_NEAR(PortableSin(angle), std::sin(angle), 2e-14) << angle;
    EXPECT_NEAR(PortableCos(angle), std::cos(angle), 2e-14) << angle;
  }
}

TEST(TruncatedNormal, StaysInsideAndHasTheMomentsOfItsDistribution) {
  // Truncated at 2.5 the variance is 1 - 2 * 2.5 * phi(2.5) / (2 * Phi(2.5) - 1) = 0.91125.
  Random random(3);
  const int n = 40000;
  double sum = 0;
  double squares = 0;
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    const double x = TruncatedNormal(random, 2.5);
    sum += x;
    squares += x * x;
    largest = std::max(largest, std::abs(x));
  }
  EXPECT_LE(largest, 2.5);
  EXPECT_NEAR(sum / n, 0.0, 0.02);  // four standard errors
  EXPECT_NEAR(squares / n, 0.91125, 0.025);
}

TEST(StreamSeed, TellsStreamsApart) {
  EXPECT_NE(StreamSeed(1, 2, 3), StreamSeed(1, 3, 2));
  EXPECT_NE(StreamSeed(1, 2, 3), StreamSeed(2, 2, 3));
  EXPECT_EQ(StreamSeed(1, 2, 3), StreamSeed(1, 2, 3));
}

}  // namespace
}  // namespace cohort
