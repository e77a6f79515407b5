#include "common/analysis/outliers.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"

namespace cohort {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsNan;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(RobustZ, AgreesWithSciPysMedianAbsoluteDeviation) {
  const std::vector<double>& expected = ReferenceValues("scipy.txt")["robust_z"];
  const std::vector<double> ours = RobustZ(MeanDistances(ReferenceMatrix("a")));
  ASSERT_EQ(ours.size(), expected.size());
  for (size_t i = 0; i < ours.size(); ++i) {
    EXPECT_NEAR(ours[i], expected[i], 1e-10);
  }
}

TEST(RobustZ, FlagsTheOneFarAway) {
  const std::vector<double> z = RobustZ(std::vector<double>{1, 2, 3, 4, 100});
  EXPECT_DOUBLE_EQ(z[4], 0.6745 * 97);
  EXPECT_GT(z[4], kOutlierZ);
  EXPECT_LT(z[3], kOutlierZ);
  EXPECT_EQ(z[2], 0);
}

TEST(RobustZ, TakesTheMeanDeviationWhenMostAreEqual) {
  // |x - median|: 0 0 0 0 10, mean 2.
  const std::vector<double> z = RobustZ(std::vector<double>{5, 5, 5, 5, 15});
  EXPECT_DOUBLE_EQ(z[4], 10 / (1.2533 * 2));
  EXPECT_EQ(z[0], 0);
}

TEST(RobustZ, IsZeroWhenAllAreEqualAndUnknownOfTwo) {
  EXPECT_THAT(RobustZ(std::vector<double>{5, 5, 5}), Each(0.0));
  EXPECT_THAT(RobustZ(std::vector<double>{5, 6, kNaN}), Each(IsNan()));
  EXPECT_TRUE(std::isnan(RobustZ(std::vector<double>{1, 2, 3, kNaN})[3]));
}

TEST(MeanDistances, LeaveOutTheDiagonalAndWhatIsMissing) {
  MetricMatrix matrix;
  matrix.labels = {"a", "b", "c"};
  matrix.values.resize(3, 3);
  matrix.values << 9, 1, 3, 1, 9, kNaN, kNaN, kNaN, 9;
  EXPECT_THAT(MeanDistances(matrix), ElementsAre(2, 1, IsNan()));
}

TEST(MedianOf, TakesTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(MedianOf(std::vector<double>{4, 1, kNaN, 2, 3}), 2.5);
  EXPECT_EQ(MedianOf(std::vector<double>{4, 1, 2}), 2);
  EXPECT_TRUE(std::isnan(MedianOf(std::vector<double>{kNaN})));
}

}  // namespace
}  // namespace cohort
