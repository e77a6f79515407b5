#include "common/geometry/comparison/measure_distances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/comparison/order_statistic.h"
#include "tests/common/geometry/comparison/fields.h"

namespace cohort {
namespace {

using testing::AbsoluteFields;
using testing::FaceLikeField;
using testing::SignedFields;

std::vector<uint64_t> Bits(const MetricValues& values) {
  std::vector<uint64_t> bits;
  for (const double value : values) {
    bits.push_back(std::bit_cast<uint64_t>(value));
  }
  return bits;
}

/// Brute force in extended precision, sorted where it must be.
struct Truth {
  long double mean = 0;
  long double rms = 0;
  long double variance = 0;
  long double geometric_mean = 0;
  std::vector<float> sorted;
};

Truth TruthOf(const std::vector<float>& field) {
  Truth truth;
  const auto n = static_cast<long double>(field.size());
  long double sum = 0;
  long double squares = 0;
  long double logs = 0;
  for (const float value : field) {
    sum += value;
    squares += static_cast<long double>(value) * value;
    logs += std::log(static_cast<long double>(value));
  }
  truth.mean = sum / n;
  truth.rms = std::sqrt(squares / n);
  truth.geometric_mean = std::exp(logs / n);
  for (const float value : field) {
    truth.variance += (value - truth.mean) * (value - truth.mean) / n;
  }
  truth.sorted = field;
  std::sort(truth.sorted.begin(), truth.sorted.end());
  return truth;
}

void ExpectNear(double value, long double truth, const std::string& what) {
  // Some thousand roundings of 1e-16 each, nearly all of which cancel.
  EXPECT_NEAR(value, static_cast<double>(truth), 1e-13 * std::abs(static_cast<double>(truth)))
      << what;
}

double Of(const DistanceSummary& summary, Metric metric) {
  return summary.metrics.at(static_cast<size_t>(metric));
}

TEST(MeasureDistances, AgreesWithBruteForceForEveryDistribution) {
  DistanceScratch scratch;
  for (const auto& [name, field] : AbsoluteFields(4099)) {
    const Truth truth = TruthOf(field);
    const DistanceSummary summary = MeasureDistances(field, DistanceSign::kAbsolute, scratch);
    ExpectNear(Of(summary, Metric::kMean), truth.mean, name + " mean");
    ExpectNear(Of(summary, Metric::kRms), truth.rms, name + " rms");
    ExpectNear(Of(summary, Metric::kGeometricMean), truth.geometric_mean, name + " geometric");
    // The deviations are from a mean that is rounded to double.
    const double tolerance = 1e-12 * static_cast<double>(truth.variance) +
                             1e-30 * static_cast<double>(truth.mean * truth.mean);
    EXPECT_NEAR(Of(summary, Metric::kVariance), static_cast<double>(truth.variance), tolerance)
        << name;
    EXPECT_EQ(Of(summary, Metric::kMin), double{truth.sorted.front()}) << name;
    EXPECT_EQ(Of(summary, Metric::kMax), double{truth.sorted.back()}) << name;
    const auto rank = static_cast<size_t>(PercentileRank(4099, 0.75));
    EXPECT_EQ(Of(summary, Metric::kPercentile75), double{truth.sorted.at(rank)}) << name;
  }
}

TEST(MeasureDistances, OfSignedValuesIsAlgebraic) {
  const std::vector<float> field = {-8, 1, -2, 4};
  DistanceScratch scratch;
  const DistanceSummary summary = MeasureDistances(field, DistanceSign::kSigned, scratch);
  EXPECT_DOUBLE_EQ(Of(summary, Metric::kRms), std::sqrt(85.0 / 4));
  EXPECT_EQ(Of(summary, Metric::kMean), -1.25);
  EXPECT_TRUE(std::isnan(Of(summary, Metric::kGeometricMean)));
  EXPECT_EQ(Of(summary, Metric::kMin), -8);
  EXPECT_EQ(Of(summary, Metric::kMax), 4);
  EXPECT_DOUBLE_EQ(Of(summary, Metric::kVariance), 85.0 / 4 - 1.25 * 1.25);
  EXPECT_EQ(Of(summary, Metric::kPercentile75), 1);  // |sorted[2]|
}

TEST(MeasureDistances, TakesThePercentileOfSignedValuesAbsolute) {
  const std::vector<float> field = {-8, -4, -2, 0.5F};
  DistanceScratch scratch;
  const DistanceSummary summary = MeasureDistances(field, DistanceSign::kSigned, scratch);
  EXPECT_EQ(Of(summary, Metric::kPercentile75), 2);  // |sorted[2]|
}

TEST(MeasureDistances, KeepsBothKindsOfSumsOfSignedValues) {
  const std::vector<float> field = FaceLikeField(3001, 5);
  DistanceScratch scratch;
  const FieldTotals with_sign =
      MeasureDistances(field, DistanceSign::kSigned, scratch).sketch.totals;
  const FieldTotals without =
      MeasureDistances(testing::Absolute(field), DistanceSign::kAbsolute, scratch).sketch.totals;
  EXPECT_EQ(with_sign.sum_absolute, without.sum);
  EXPECT_EQ(with_sign.sum_squares, without.sum_squares);
  EXPECT_EQ(with_sign.log_mean, without.log_mean);
  EXPECT_EQ(with_sign.min_absolute, without.min);
  EXPECT_LT(std::abs(with_sign.sum), without.sum);
}

class MeasureOfSize : public ::testing::TestWithParam<int> {};

/// One test for all: the loop is over what this machine can run.
TEST_P(MeasureOfSize, HasTheSameBitsOnEveryInstructionSet) {
  DistanceScratch scratch;
  for (const auto& [name, field] : SignedFields(GetParam())) {
    std::vector<float> squares;
    for (const float value : field) {
      squares.push_back(value * value);
    }
    const std::vector<float> absolute = testing::Absolute(field);
    const auto& portable = *PortableFieldKernels();
    for (const FieldKernels* kernels : RunnableFieldKernels()) {
      const std::string what = name + " " + std::string(kernels->name);
      for (const FieldInput input :
           {FieldInput::kSquared, FieldInput::kAbsolute, FieldInput::kSigned}) {
        const std::vector<float>& values = input == FieldInput::kSquared    ? squares
                                           : input == FieldInput::kAbsolute ? absolute
                                                                            : field;
        const DistanceSummary expected = MeasureWith(portable, input, values, scratch);
        const std::vector<float> distances = scratch.distances;
        const DistanceSummary summary = MeasureWith(*kernels, input, values, scratch);
        EXPECT_EQ(Bits(summary.metrics), Bits(expected.metrics)) << what;
        EXPECT_TRUE(summary.sketch == expected.sketch) << what;
        EXPECT_EQ(scratch.distances, distances) << what;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Sizes, MeasureOfSize, ::testing::Values(1, 15, 16, 17, 31, 1024, 5003));

TEST(RunnableFieldKernels, BeginWithThePortableOnesAndHoldTheBest) {
  EXPECT_EQ(RunnableFieldKernels().front()->name, "portable");
  EXPECT_THAT(RunnableFieldKernels(), ::testing::Contains(&BestFieldKernels()));
}

/// Golden values: they hold on every machine, compiler and instruction set, or results differ.
TEST(MeasureDistances, HasTheBitsItHadWhenItWasWritten) {
  DistanceScratch scratch;
  std::vector<float> field;
  field.reserve(1000);
  for (int i = 0; i < 1000; ++i) {
    field.push_back(static_cast<float>((i * 37) % 1000 + 1) / 128.0F);
  }
  const DistanceSummary summary = MeasureDistances(field, DistanceSign::kAbsolute, scratch);
  EXPECT_EQ(Of(summary, Metric::kMean), 500.5 / 128);
  EXPECT_EQ(Of(summary, Metric::kRms), std::sqrt(333833.5) / 128);
  // One unit in the last place above the true value, 0x1.717ddda844b4ap+1.
  EXPECT_EQ(Of(summary, Metric::kGeometricMean), 0x1.717ddda844b4bp+1);
  EXPECT_EQ(Of(summary, Metric::kPercentile75), 750.0 / 128);
}

TEST(MeasureSquaredDistances, LeavesTheRootsInTheScratch) {
  const std::vector<float> squares = {4, 2, 0, 9, 16};
  DistanceScratch scratch;
  static_cast<void>(MeasureSquaredDistances(squares, scratch));
  EXPECT_THAT(scratch.distances, ::testing::ElementsAre(2, std::sqrt(2.0F), 0, 3, 4));
}

TEST(MeasureDistances, OfTheRootsEqualsMeasureSquaredDistances) {
  std::vector<float> squares;
  for (const float value : FaceLikeField(1001, 9)) {
    squares.push_back(value * value);
  }
  DistanceScratch scratch;
  const DistanceSummary direct = MeasureSquaredDistances(squares, scratch);
  const std::vector<float> kept = scratch.distances;
  const DistanceSummary again = MeasureDistances(kept, DistanceSign::kAbsolute, scratch);
  EXPECT_EQ(Bits(again.metrics), Bits(direct.metrics));
  EXPECT_TRUE(again.sketch == direct.sketch);
}

TEST(MeasureDistances, OrdersTheMeansEvenIfRoundingWouldNot) {
  DistanceScratch scratch;
  for (const auto& [name, field] : AbsoluteFields(997)) {
    const DistanceSummary summary = MeasureDistances(field, DistanceSign::kAbsolute, scratch);
    EXPECT_LE(Of(summary, Metric::kMin), Of(summary, Metric::kGeometricMean)) << name;
    EXPECT_LE(Of(summary, Metric::kGeometricMean), Of(summary, Metric::kMean)) << name;
    EXPECT_LE(Of(summary, Metric::kMean), Of(summary, Metric::kRms)) << name;
    EXPECT_LE(Of(summary, Metric::kRms), Of(summary, Metric::kMax)) << name;
  }
}

class BinsOf : public ::testing::TestWithParam<DistanceSign> {};

TEST_P(BinsOf, CountTheValuesBetweenTheirEdges) {
  DistanceScratch scratch;
  const bool has_signs = GetParam() == DistanceSign::kSigned;
  for (const auto& [name, field] : has_signs ? SignedFields(2003) : AbsoluteFields(2003)) {
    const DistanceSketch sketch = MeasureDistances(field, GetParam(), scratch).sketch;
    std::array<uint32_t, kSketchBins> expected{};
    for (const float value : field) {
      // Division by a power of two is exact.
      const double bin = std::floor(double{value} / sketch.bin_width) - sketch.FirstBin();
      ++expected.at(static_cast<size_t>(std::clamp(bin, 0.0, kSketchBins - 1.0)));
    }
    EXPECT_EQ(sketch.bins, expected) << name;
  }
}
INSTANTIATE_TEST_SUITE_P(Signs,
                         BinsOf,
                         ::testing::Values(DistanceSign::kAbsolute, DistanceSign::kSigned));

TEST(SketchBinWidth, FollowsTheFieldInPowersOfTwo) {
  EXPECT_EQ(SketchBinWidth(DistanceSign::kAbsolute, 6.3, 2), 8.0 / 512);
  EXPECT_EQ(SketchBinWidth(DistanceSign::kSigned, 6.3, 2), 8.0 / 256);
  EXPECT_EQ(SketchBinWidth(DistanceSign::kAbsolute, 8, 2), 16.0 / 512);
  EXPECT_EQ(SketchBinWidth(DistanceSign::kAbsolute, 0.0063, 0.002), 0.0078125 / 512);
  EXPECT_EQ(SketchBinWidth(DistanceSign::kAbsolute, 1e6, 1.5), 16.0 / 512);  // 8 RMS
  EXPECT_EQ(SketchBinWidth(DistanceSign::kAbsolute, 0, 0), 0x1p-109);
}

TEST(SelectPercentile, IsTheSortedValue) {
  DistanceScratch scratch;
  for (const auto& [name, field] : SignedFields(3001)) {
    const DistanceSketch sketch = MeasureDistances(field, DistanceSign::kSigned, scratch).sketch;
    std::vector<float> sorted = field;
    std::sort(sorted.begin(), sorted.end());
    for (const double q : {0.0, 0.05, 0.5, 0.95, 1.0}) {
      EXPECT_EQ(SelectPercentile(field, sketch, q, scratch),
                sorted.at(static_cast<size_t>(PercentileRank(3001, q))))
          << name << " " << q;
    }
  }
}

}  // namespace
}  // namespace cohort
