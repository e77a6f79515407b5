#include "common/geometry/comparison/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "common/geometry/comparison/field_totals.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/order_statistic.h"

namespace cohort {
namespace {

struct MetricNames {
  std::string_view name;
  std::string_view title;
};
constexpr std::array<MetricNames, kMetricCount> kNames = {{
    {"rms", "RMS distance"},
    {"mean", "Mean distance"},
    {"geometric-mean", "Geometric mean distance"},
    {"min", "Minimum distance"},
    {"max", "Maximum distance"},
    {"variance", "Variance of distances"},
    {"p75", "75th percentile of distances"},
}};

/// The lanes of ComputeMetrics: the same sums for values in double, of any exponent.
constexpr size_t kLanes = 16;

template <typename Value>
double LaneSum(std::span<const double> values, Value value_of) {
  std::array<double, kLanes> lanes{};
  for (size_t i = 0; i < values.size(); ++i) {
    lanes.at(i % kLanes) += value_of(values[i]);
  }
  double sum = 0;
  for (const double lane : lanes) {
    sum += lane;
  }
  return sum;
}

double LogMean(std::span<const double> values) {
  std::array<double, kLanes> mantissas{};
  std::array<int64_t, kLanes> exponents{};
  mantissas.fill(1);
  for (size_t i = 0; i < values.size(); ++i) {
    // Scaled first, so that the product neither overflows nor loses bits.
    int value_exponent = 0;
    int product_exponent = 0;
    const double value_mantissa = std::frexp(values[i], &value_exponent);
    double& mantissa = mantissas.at(i % kLanes);
    mantissa = 2 * std::frexp(mantissa * value_mantissa, &product_exponent);
    exponents.at(i % kLanes) += value_exponent + product_exponent - 1;
  }
  return LogMeanOfProduct(mantissas, exponents, static_cast<int64_t>(values.size()));
}

FieldTotals Total(std::span<const double> values) {
  FieldTotals totals;
  totals.count = static_cast<int64_t>(values.size());
  totals.sum = LaneSum(values, [](double value) { return value; });
  totals.sum_absolute = totals.sum;
  totals.sum_squares = LaneSum(values, [](double value) { return value * value; });
  const double mean = totals.sum / static_cast<double>(totals.count);
  totals.squared_deviations =
      LaneSum(values, [mean](double value) { return (value - mean) * (value - mean); });
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  totals.min = *min;
  totals.max = *max;
  totals.min_absolute = *min;
  totals.log_mean = *min == 0 ? -std::numeric_limits<double>::infinity() : LogMean(values);
  return totals;
}

double Percentile75(std::span<const double> values) {
  std::vector<double> partly_sorted(values.begin(), values.end());
  const auto nth =
      partly_sorted.begin() + PercentileRank(static_cast<int64_t>(partly_sorted.size()), 0.75);
  std::nth_element(partly_sorted.begin(), nth, partly_sorted.end());
  return *nth;
}

}  // namespace

std::string_view MetricName(Metric metric) {
  return kNames.at(static_cast<size_t>(metric)).name;
}

std::string_view MetricTitle(Metric metric) {
  return kNames.at(static_cast<size_t>(metric)).title;
}

std::optional<Metric> MetricFromName(std::string_view name) {
  for (const Metric metric : kAllMetrics) {
    if (MetricName(metric) == name) {
      return metric;
    }
  }
  return std::nullopt;
}

MetricValues ComputeMetrics(std::span<const float> squared_distances) {
  DistanceScratch scratch;
  return MeasureSquaredDistances(squared_distances, scratch).metrics;
}

MetricValues MetricsOfDistances(std::span<const double> distances) {
  assert(!distances.empty());
  MetricValues metrics = MetricsOfTotals(Total(distances));
  metrics.at(static_cast<size_t>(Metric::kPercentile75)) = Percentile75(distances);
  return metrics;
}

}  // namespace cohort
