#include "common/geometry/comparison/measure_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/order_statistic.h"
#include "tests/common/geometry/comparison/fields.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::Absolute;
using testing::AbsoluteFields;
using ::testing::ElementsAreArray;
using testing::FaceLikeField;
using testing::SignedFields;
using testing::StatusIs;

constexpr DistanceSign kSigned = DistanceSign::kSigned;

double Of(const FieldMeasure& measure, Metric metric) {
  return measure.metrics.at(static_cast<size_t>(metric));
}

std::vector<uint64_t> Bits(const MetricValues& values) {
  std::vector<uint64_t> bits;
  for (const double value : values) {
    bits.push_back(std::bit_cast<uint64_t>(value));
  }
  return bits;
}

/// The thresholds of the predecessor, by sorting: reference c7.
std::vector<float> WindowBySorting(std::vector<float> values, double lower, double upper) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  const auto first = static_cast<std::ptrdiff_t>(n * lower - 0.5);
  const auto end = static_cast<std::ptrdiff_t>(n * upper - 0.5);
  return {values.begin() + first, values.begin() + end};
}

TEST(MeasureField, WithoutThresholdsEqualsMeasureDistances) {
  const std::vector<float> field = FaceLikeField(1234, 1);
  DistanceScratch scratch;
  const auto with_sign = MeasureField(field, {.sign = kSigned});
  ASSERT_THAT(with_sign, testing::IsOk());
  EXPECT_THAT(Bits(with_sign->metrics),
              ElementsAreArray(Bits(MeasureDistances(field, kSigned, scratch).metrics)));
  const auto absolute = MeasureField(field, {});
  ASSERT_THAT(absolute, testing::IsOk());
  EXPECT_THAT(Bits(absolute->metrics),
              ElementsAreArray(Bits(
                  MeasureDistances(Absolute(field), DistanceSign::kAbsolute, scratch).metrics)));
  EXPECT_EQ(absolute->count, 1234);
}

TEST(MeasureField, GivesAnyPercentile) {
  const std::vector<float> field = FaceLikeField(1000, 2);
  std::vector<float> sorted = Absolute(field);
  std::sort(sorted.begin(), sorted.end());
  for (const double q : {0.0, 0.25, 0.5, 0.95, 1.0}) {
    const auto measure = MeasureField(field, {.percentile = q});
    ASSERT_THAT(measure, testing::IsOk());
    EXPECT_EQ(measure->percentile, double{sorted.at(static_cast<size_t>(PercentileRank(1000, q)))});
  }
}

struct Shares {
  double lower;
  double upper;
};
class FieldWindow : public ::testing::TestWithParam<Shares> {};

TEST_P(FieldWindow, MeasuresTheSortedValuesOfThePredecessor) {
  const auto [lower, upper] = GetParam();
  for (const DistanceSign sign : {DistanceSign::kAbsolute, kSigned}) {
    for (const auto& [name, field] : SignedFields(1003)) {
      const std::vector<float> window =
          WindowBySorting(sign == kSigned ? field : Absolute(field), lower, upper);
      const auto expected = MeasureField(window, {.sign = sign, .percentile = 0.3});
      const auto measure = MeasureField(
          field, {.sign = sign, .percentile = 0.3, .lower_share = lower, .upper_share = upper});
      ASSERT_THAT(expected, testing::IsOk());
      ASSERT_THAT(measure, testing::IsOk());
      EXPECT_EQ(measure->count, static_cast<int64_t>(window.size())) << name;
      EXPECT_EQ(measure->percentile, expected->percentile) << name;
      EXPECT_EQ(Of(*measure, Metric::kMin), Of(*expected, Metric::kMin)) << name;
      EXPECT_EQ(Of(*measure, Metric::kMax), Of(*expected, Metric::kMax)) << name;
      const double rms = Of(*expected, Metric::kRms);
      EXPECT_NEAR(Of(*measure, Metric::kRms), rms, 1e-13 * rms) << name;
      EXPECT_NEAR(Of(*measure, Metric::kMean), Of(*expected, Metric::kMean), 1e-13 * rms) << name;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Shares,
                         FieldWindow,
                         ::testing::Values(Shares{0, 0.9},
                                           Shares{0.1, 1},
                                           Shares{0.25, 0.75},
                                           Shares{0.5, 0.501},
                                           Shares{0.999, 1}));

TEST(MeasureField, AgreesWithTheExactPredecessorUnderThresholds) {
  const std::vector<float> field = FaceLikeField(500, 3);
  const auto measure = MeasureField(field, {.sign = kSigned, .lower_share = 0.1, .upper_share = 1});
  ASSERT_THAT(measure, testing::IsOk());
  const FidentisMetricValues old =
      ComputeFidentisMetrics(FidentisWindow(field, {.lower = 0.1, .upper = 1}));
  for (const Metric metric : {Metric::kRms, Metric::kMean, Metric::kMin, Metric::kMax,
                              Metric::kVariance, Metric::kPercentile75}) {
    // The predecessor adds in float32.
    EXPECT_NEAR(Of(*measure, metric), double{old.at(static_cast<size_t>(metric))}, 1e-4);
  }
}

TEST(MeasureField, LosesTheLargestValueWithALowerThresholdAlone) {
  const auto measure = MeasureField(std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
                                    {.lower_share = 0.2, .upper_share = 1});
  ASSERT_THAT(measure, testing::IsOk());
  EXPECT_EQ(measure->count, 8);
  EXPECT_EQ(Of(*measure, Metric::kMin), 2);
  EXPECT_EQ(Of(*measure, Metric::kMax), 9);
}

TEST(MeasureField, IsZeroIfTheThresholdsCross) {
  const auto measure =
      MeasureField(FaceLikeField(100, 4), {.lower_share = 0.6, .upper_share = 0.6});
  ASSERT_THAT(measure, testing::IsOk());
  EXPECT_THAT(measure->metrics, ::testing::Each(0.0));
  EXPECT_EQ(measure->count, 1);
}

TEST(MeasureField, RefusesThresholdsThatLeaveNothing) {
  EXPECT_THAT(MeasureField(std::vector<float>{1, 2, 3}, {.upper_share = 0.3}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "leave none of 3"));
}

TEST(MeasureField, NamesTheValueThatIsNotFinite) {
  const std::vector<float> field = {1, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_THAT(MeasureField(field, {}), StatusIs(absl::StatusCode::kInvalidArgument, "value 1"));
  EXPECT_THAT(MeasureField({}, {}), StatusIs(absl::StatusCode::kInvalidArgument, "no value"));
}

TEST(FieldOptions, RefuseWhatIsNoShare) {
  EXPECT_THAT(FieldOptions{.percentile = 1.5}.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "percentile 1.5"));
  EXPECT_THAT(FieldOptions{.lower_share = -0.1}.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "lower threshold -0.1"));
  EXPECT_THAT(FieldOptions{.upper_share = std::nan("")}.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "upper threshold"));
}

TEST(MeasureWeightedField, WithEqualWeightsEqualsMeasureField) {
  for (const auto& [name, field] : AbsoluteFields(777)) {
    for (const auto& [lower, upper] : {Shares{0, 1}, Shares{0.1, 0.8}}) {
      const FieldOptions options{.percentile = 0.9, .lower_share = lower, .upper_share = upper};
      const auto expected = MeasureField(field, options);
      const auto measure =
          MeasureWeightedField(field, std::vector<double>(field.size(), 0.25), options);
      ASSERT_THAT(expected, testing::IsOk());
      ASSERT_THAT(measure, testing::IsOk());
      EXPECT_EQ(measure->count, expected->count) << name;
      EXPECT_EQ(measure->percentile, expected->percentile) << name;
      for (const Metric metric : kAllMetrics) {
        const double truth = Of(*expected, metric);
        const double scale =
            metric == Metric::kVariance ? std::pow(Of(*expected, Metric::kRms), 2) : truth;
        EXPECT_NEAR(Of(*measure, metric), truth, 1e-12 * scale) << name << MetricName(metric);
      }
    }
  }
}

TEST(MeasureWeightedField, WithWholeWeightsEqualsRepeatedValues) {
  const std::vector<float> field = Absolute(FaceLikeField(200, 5));
  std::vector<double> weights;
  std::vector<float> repeated;
  for (size_t i = 0; i < field.size(); ++i) {
    weights.push_back(static_cast<double>(i % 4));
    repeated.insert(repeated.end(), i % 4, field.at(i));
  }
  const auto measure = MeasureWeightedField(field, weights, {});
  const auto expected = MeasureField(repeated, {});
  ASSERT_THAT(measure, testing::IsOk());
  ASSERT_THAT(expected, testing::IsOk());
  EXPECT_EQ(measure->count, 150);  // Every fourth weighs nothing.
  EXPECT_NEAR(Of(*measure, Metric::kMean), Of(*expected, Metric::kMean), 1e-13);
  EXPECT_NEAR(Of(*measure, Metric::kRms), Of(*expected, Metric::kRms), 1e-13);
  EXPECT_NEAR(Of(*measure, Metric::kVariance), Of(*expected, Metric::kVariance), 1e-13);
  EXPECT_NEAR(Of(*measure, Metric::kGeometricMean), Of(*expected, Metric::kGeometricMean), 1e-13);
  EXPECT_EQ(Of(*measure, Metric::kMin), Of(*expected, Metric::kMin));
  EXPECT_EQ(Of(*measure, Metric::kMax), Of(*expected, Metric::kMax));
}

TEST(MeasureWeightedField, TakesThePercentileByWeight) {
  // Middles at (0.5, 1.5, 5, 8.5) of 9.
  const std::vector<float> field = {4, 1, 3, 2};
  const std::vector<double> weights = {1, 1, 6, 1};
  const auto measure = MeasureWeightedField(field, weights, {.percentile = 0.5});
  ASSERT_THAT(measure, testing::IsOk());
  EXPECT_EQ(measure->percentile, 2);
  EXPECT_EQ(Of(*measure, Metric::kPercentile75), 3);
  EXPECT_DOUBLE_EQ(Of(*measure, Metric::kMean), 25.0 / 9);
}

TEST(MeasureWeightedField, LeavesOutWhatWeighsNothing) {
  const std::vector<float> field = {-100, 1, 2, 100};
  const std::vector<double> weights = {0, 1, 1, 0};
  const auto measure = MeasureWeightedField(field, weights, {.sign = kSigned});
  ASSERT_THAT(measure, testing::IsOk());
  EXPECT_EQ(measure->count, 2);
  EXPECT_EQ(Of(*measure, Metric::kMin), 1);
  EXPECT_EQ(Of(*measure, Metric::kMax), 2);
  EXPECT_NEAR(Of(*measure, Metric::kGeometricMean), std::sqrt(2.0), 1e-15);
}

TEST(MeasureWeightedField, RefusesWeightsThatAreNone) {
  const std::vector<float> field = {1, 2};
  EXPECT_THAT(MeasureWeightedField(field, std::vector<double>{1}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "1 weights for 2 distances"));
  EXPECT_THAT(MeasureWeightedField(field, std::vector<double>{1, -1}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "weight 1 is -1"));
  EXPECT_THAT(MeasureWeightedField(field, std::vector<double>{0, 0}, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "all 2 weights are 0"));
}

}  // namespace
}  // namespace cohort
