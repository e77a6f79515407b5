#include "common/geometry/comparison/metrics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

/// Sums of some 1000 doubles in another order or another form.
constexpr double kTolerance = 1e-12;

double Of(const MetricValues& values, Metric metric) {
  return values.at(static_cast<size_t>(metric));
}

std::vector<float> RandomSquares(int count, uint64_t seed) {
  Random random(seed);
  std::vector<float> squares;
  squares.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    squares.push_back(static_cast<float>(random.Uniform(0.001, 30)));
  }
  return squares;
}

TEST(ComputeMetrics, MatchesHandComputedValues) {
  const std::vector<float> squares = {1, 4, 16, 64};  // distances 1, 2, 4, 8
  const MetricValues values = ComputeMetrics(squares);
  EXPECT_DOUBLE_EQ(Of(values, Metric::kRms), std::sqrt(85.0 / 4));
  EXPECT_DOUBLE_EQ(Of(values, Metric::kMean), 3.75);
  EXPECT_NEAR(Of(values, Metric::kGeometricMean), std::pow(64.0, 0.25), kTolerance);
  EXPECT_EQ(Of(values, Metric::kMin), 1);
  EXPECT_EQ(Of(values, Metric::kMax), 8);
  EXPECT_DOUBLE_EQ(Of(values, Metric::kVariance), 85.0 / 4 - 3.75 * 3.75);
  EXPECT_EQ(Of(values, Metric::kPercentile75), 4);  // sorted[trunc(2.5)]
}

TEST(ComputeMetrics, RootsInSinglePrecision) {
  const std::vector<float> squares = {2};
  const MetricValues values = ComputeMetrics(squares);
  const double root = double{std::sqrt(2.0F)};
  EXPECT_EQ(Of(values, Metric::kMean), root);
  EXPECT_EQ(Of(values, Metric::kMin), root);
  EXPECT_EQ(Of(values, Metric::kMax), root);
  EXPECT_EQ(Of(values, Metric::kPercentile75), root);
  EXPECT_EQ(Of(values, Metric::kRms), root);
  EXPECT_EQ(Of(values, Metric::kVariance), 0);
}

TEST(ComputeMetrics, GeometricMeanIsZeroIfAnyDistanceIs) {
  const std::vector<float> squares = {1, 0, 4};
  EXPECT_EQ(Of(ComputeMetrics(squares), Metric::kGeometricMean), 0);
}

TEST(ComputeMetrics, OfIdenticalMeshesAreAllZero) {
  const std::vector<float> squares(10, 0.0F);
  EXPECT_THAT(ComputeMetrics(squares), ::testing::Each(0.0));
}

TEST(ComputeMetrics, OrdersTheMeans) {
  const MetricValues values = ComputeMetrics(RandomSquares(1000, 1));
  EXPECT_LE(Of(values, Metric::kMin), Of(values, Metric::kGeometricMean));
  EXPECT_LE(Of(values, Metric::kGeometricMean), Of(values, Metric::kMean));
  EXPECT_LE(Of(values, Metric::kMean), Of(values, Metric::kRms));
  EXPECT_LE(Of(values, Metric::kRms), Of(values, Metric::kMax));
  EXPECT_LE(Of(values, Metric::kPercentile75), Of(values, Metric::kMax));
}

TEST(ComputeMetrics, VarianceIsMeanSquareMinusSquaredMean) {
  const MetricValues values = ComputeMetrics(RandomSquares(1000, 2));
  const double rms = Of(values, Metric::kRms);
  const double mean = Of(values, Metric::kMean);
  EXPECT_NEAR(Of(values, Metric::kVariance), rms * rms - mean * mean, 1e-10);
}

class Percentile75 : public ::testing::TestWithParam<int> {};

TEST_P(Percentile75, IsTheDocumentedRankOfTheSortedValues) {
  const int n = GetParam();
  const std::vector<float> squares = RandomSquares(n, 3);
  std::vector<float> sorted = squares;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = static_cast<size_t>(0.75 * n - 0.5);
  EXPECT_EQ(Of(ComputeMetrics(squares), Metric::kPercentile75), double{std::sqrt(sorted.at(rank))});
}
INSTANTIATE_TEST_SUITE_P(Sizes, Percentile75, ::testing::Values(1, 2, 3, 4, 5, 100, 1001));

TEST(MetricsOfDistances, EqualComputeMetricsOnTheSquares) {
  const std::vector<float> squares = RandomSquares(777, 4);
  std::vector<double> distances;
  distances.reserve(squares.size());
  for (const float square : squares) {
    distances.push_back(double{std::sqrt(square)});
  }
  EXPECT_EQ(MetricsOfDistances(distances), ComputeMetrics(squares));
}

TEST(MetricName, IsInvertedByMetricFromName) {
  std::vector<Metric> round_trip;
  round_trip.reserve(kMetricCount);
  for (const Metric metric : kAllMetrics) {
    round_trip.push_back(MetricFromName(MetricName(metric)).value());
  }
  EXPECT_THAT(round_trip, ::testing::ElementsAreArray(kAllMetrics));
}

TEST(MetricName, IsAsDocumented) {
  EXPECT_EQ(MetricName(Metric::kRms), "rms");
  EXPECT_EQ(MetricName(Metric::kMean), "mean");
  EXPECT_EQ(MetricName(Metric::kGeometricMean), "geometric-mean");
  EXPECT_EQ(MetricName(Metric::kMin), "min");
  EXPECT_EQ(MetricName(Metric::kMax), "max");
  EXPECT_EQ(MetricName(Metric::kVariance), "variance");
  EXPECT_EQ(MetricName(Metric::kPercentile75), "p75");
  EXPECT_EQ(MetricTitle(Metric::kRms), "RMS distance");
}

TEST(MetricFromName, IsEmptyForAnUnknownName) {
  EXPECT_FALSE(MetricFromName("median").has_value());
  EXPECT_FALSE(MetricFromName("").has_value());
}

}  // namespace
}  // namespace cohort
