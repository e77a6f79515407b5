#include "common/geometry/comparison/sketch_measure.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/comparison/measure_distances.h"
#include "tests/common/geometry/comparison/fields.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::Absolute;
using testing::FaceLikeField;
using testing::SignedFields;
using testing::StatusIs;

DistanceSketch SketchOf(const std::vector<float>& field, DistanceSign sign) {
  DistanceScratch scratch;
  return MeasureDistances(field, sign, scratch).sketch;
}

/// Rounding in double of sums over some thousand values: left out of the bounds.
constexpr double kRounding = 1e-12;

void ExpectWithin(double value, double bound, double truth, double scale, const std::string& what) {
  if (std::isnan(truth) || std::isnan(value)) {
    EXPECT_EQ(std::isnan(value), std::isnan(truth)) << what;
    return;
  }
  EXPECT_LE(std::abs(value - truth), bound + kRounding * scale)
      << what << ": " << value << " +- " << bound << ", true " << truth;
}

struct Question {
  FieldOptions options;
  DistanceSign kept;
};
class SketchBounds : public ::testing::TestWithParam<Question> {};

TEST_P(SketchBounds, HoldForEveryDistribution) {
  const auto [options, kept] = GetParam();
  for (const int n : {1, 2, 50, 6007}) {
    for (const auto& [name, field] : SignedFields(n)) {
      const std::vector<float> values = kept == DistanceSign::kSigned ? field : Absolute(field);
      const auto truth = MeasureField(values, options);
      const auto answer = MeasureSketch(SketchOf(values, kept), options);
      ASSERT_EQ(truth.ok(), answer.ok()) << name << n;
      if (!truth.ok()) {
        EXPECT_EQ(answer.status().ToString(), truth.status().ToString());
        continue;
      }
      EXPECT_EQ(answer->value.count, truth->count);
      const double rms = truth->metrics.at(static_cast<size_t>(Metric::kRms));
      const double largest = std::abs(truth->metrics.at(static_cast<size_t>(Metric::kMax))) + rms;
      for (const Metric metric : kAllMetrics) {
        const auto i = static_cast<size_t>(metric);
        const double scale = metric == Metric::kVariance ? largest * largest : largest;
        ExpectWithin(answer->value.metrics.at(i), answer->bounds.at(i), truth->metrics.at(i), scale,
                     name + " " + std::string(MetricName(metric)));
      }
      ExpectWithin(answer->value.percentile, answer->percentile_bound, truth->percentile, largest,
                   name + " percentile");
    }
  }
}

constexpr DistanceSign kAbsolute = DistanceSign::kAbsolute;
constexpr DistanceSign kSigned = DistanceSign::kSigned;
INSTANTIATE_TEST_SUITE_P(
    Questions,
    SketchBounds,
    ::testing::Values(
        Question{{.sign = kAbsolute, .percentile = 0.5}, kAbsolute},
        Question{{.sign = kAbsolute, .percentile = 0.95}, kSigned},
        Question{{.sign = kSigned, .percentile = 0.1}, kSigned},
        Question{{.sign = kAbsolute, .percentile = 0, .upper_share = 0.9}, kAbsolute},
        Question{{.sign = kAbsolute, .percentile = 1, .upper_share = 0.9}, kSigned},
        Question{{.sign = kAbsolute, .lower_share = 0.05, .upper_share = 1}, kAbsolute},
        Question{{.sign = kAbsolute, .lower_share = 0.6, .upper_share = 0.61}, kAbsolute},
        Question{{.sign = kSigned, .lower_share = 0.1, .upper_share = 0.8}, kSigned},
        Question{{.sign = kSigned, .lower_share = 0.9, .upper_share = 1}, kSigned},
        Question{{.sign = kSigned, .lower_share = 0.9, .upper_share = 0.2}, kSigned}));

TEST(MeasureSketch, IsExactWithoutThresholdsButForPercentiles) {
  const std::vector<float> field = Absolute(FaceLikeField(5000, 1));
  DistanceScratch scratch;
  const DistanceSummary summary = MeasureDistances(field, kAbsolute, scratch);
  const auto answer = MeasureSketch(summary.sketch, {});
  ASSERT_THAT(answer, testing::IsOk());
  for (const Metric metric : {Metric::kRms, Metric::kMean, Metric::kGeometricMean, Metric::kMin,
                              Metric::kMax, Metric::kVariance}) {
    const auto i = static_cast<size_t>(metric);
    EXPECT_EQ(answer->value.metrics.at(i), summary.metrics.at(i)) << MetricName(metric);
    EXPECT_EQ(answer->bounds.at(i), 0) << MetricName(metric);
  }
}

TEST(MeasureSketch, BoundsPercentilesByOneBin) {
  const std::vector<float> field = Absolute(FaceLikeField(5000, 2));
  const DistanceSketch sketch = SketchOf(field, kAbsolute);
  for (const double q : {0.01, 0.5, 0.75, 0.99}) {
    const auto answer = MeasureSketch(sketch, {.percentile = q});
    ASSERT_THAT(answer, testing::IsOk());
    EXPECT_LE(answer->percentile_bound, sketch.bin_width);
  }
}

/// Reference performance.md 5: percentiles 2 to 7e-4 mm, RMS under a threshold 1e-4 mm off.
TEST(MeasureSketch, IsFarCloserThanItsBoundsForFaces) {
  const std::vector<float> field = Absolute(FaceLikeField(20000, 3));
  const auto truth = MeasureField(field, {.percentile = 0.95, .upper_share = 0.9});
  const auto answer =
      MeasureSketch(SketchOf(field, kAbsolute), {.percentile = 0.95, .upper_share = 0.9});
  ASSERT_THAT(truth, testing::IsOk());
  ASSERT_THAT(answer, testing::IsOk());
  EXPECT_NEAR(answer->value.percentile, truth->percentile, 2e-3);
  EXPECT_NEAR(answer->value.metrics.at(0), truth->metrics.at(0), 1e-4);
  EXPECT_LT(answer->bounds.at(0), 0.01);
}

TEST(MeasureSketch, RefusesSignsThatWereNotKept) {
  const DistanceSketch sketch = SketchOf({1, 2, 3}, kAbsolute);
  EXPECT_THAT(MeasureSketch(sketch, {.sign = kSigned}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "absolute distances"));
  EXPECT_THAT(MeasureSketch(sketch, {.percentile = 2}),
              StatusIs(absl::StatusCode::kInvalidArgument, "percentile 2"));
}

}  // namespace
}  // namespace cohort
