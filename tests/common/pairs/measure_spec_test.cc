#include "common/pairs/measure_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

TEST(ParseMeasure, KnowsEveryMetricByItsName) {
  for (const Metric metric : kAllMetrics) {
    const auto spec = ParseMeasure(std::string(MetricName(metric)));
    ASSERT_THAT(spec, IsOk());
    EXPECT_EQ(spec->metric, metric);
    EXPECT_FALSE(spec->percentile);
    EXPECT_TRUE(spec->IsPlainMetric());
    EXPECT_EQ(spec->Name(), MetricName(metric));
  }
}

TEST(ParseMeasure, ReadsPercentiles) {
  const auto spec = ParseMeasure("p99.5");
  ASSERT_THAT(spec, IsOk());
  EXPECT_DOUBLE_EQ(*spec->percentile, 0.995);
  EXPECT_FALSE(spec->IsPlainMetric());
  EXPECT_EQ(spec->Name(), "p99.5");
  EXPECT_EQ(spec->Title(), "99.5th percentile of the distances");
  EXPECT_EQ(ParseMeasure("p0")->Title(), "0th percentile of the distances");
  EXPECT_EQ(ParseMeasure("p1")->Title(), "1st percentile of the distances");
  EXPECT_EQ(ParseMeasure("p12")->Title(), "12th percentile of the distances");
  EXPECT_EQ(ParseMeasure("p22")->Title(), "22nd percentile of the distances");
  EXPECT_EQ(ParseMeasure("p93")->Title(), "93rd percentile of the distances");
}

TEST(ParseMeasure, NamesWhatItDoesNotKnow) {
  for (const char* text : {"", "p", "p-1", "p101", "pnan", "RMS", "p95x"}) {
    EXPECT_THAT(ParseMeasure(text).status(), StatusIs(absl::StatusCode::kInvalidArgument, text))
        << text;
  }
}

TEST(MeasureSpec, SaysInItsTitleWhatElseIsAsked) {
  MeasureSpec spec;
  EXPECT_EQ(spec.Title(), "RMS distance");
  spec.sign = DistanceSign::kSigned;
  spec.by_area = true;
  spec.upper_share = 0.9;
  EXPECT_EQ(spec.Title(), "RMS distance (signed, by area, from 0 to 0.9)");
  EXPECT_FALSE(spec.IsPlainMetric());
}

}  // namespace
}  // namespace cohort
