#include "common/geometry/comparison/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

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

template <typename T>
double Rms(std::span<const T> values) {
  double sum = 0;
  for (const T value : values) {
    sum += double{value} * double{value};
  }
  return std::sqrt(sum / static_cast<double>(values.size()));
}

template <typename T>
double Mean(std::span<const T> values) {
  double sum = 0;
  for (const T value : values) {
    sum += double{value};
  }
  return sum / static_cast<double>(values.size());
}

/// The logarithm of zero is -infinity and carries through the sum, so that one zero gives 0.
template <typename T>
double GeometricMean(std::span<const T> values) {
  double sum = 0;
  for (const T value : values) {
    sum += std::log(double{value});
  }
  return std::exp(sum / static_cast<double>(values.size()));
}

template <typename T>
double Variance(std::span<const T> values) {
  const double mean = Mean(values);
  double sum = 0;
  for (const T value : values) {
    sum += (double{value} - mean) * (double{value} - mean);
  }
  return sum / static_cast<double>(values.size());
}

template <typename T>
double Percentile75(std::span<const T> values) {
  std::vector<T> partly_sorted(values.begin(), values.end());
  const auto rank = static_cast<std::ptrdiff_t>(0.75 * static_cast<double>(values.size()) - 0.5);
  std::nth_element(partly_sorted.begin(), partly_sorted.begin() + rank, partly_sorted.end());
  return double{partly_sorted[static_cast<size_t>(rank)]};
}

template <typename T>
double ComputeOne(Metric metric, std::span<const T> values) {
  assert(!values.empty());
  switch (metric) {
    case Metric::kRms:
      return Rms(values);
    case Metric::kMean:
      return Mean(values);
    case Metric::kGeometricMean:
      return GeometricMean(values);
    case Metric::kMin:
      return double{*std::min_element(values.begin(), values.end())};
    case Metric::kMax:
      return double{*std::max_element(values.begin(), values.end())};
    case Metric::kVariance:
      return Variance(values);
    case Metric::kPercentile75:
      return Percentile75(values);
  }
  assert(false);
  return 0;
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
  std::vector<float> distances(squared_distances.size());
  std::transform(squared_distances.begin(), squared_distances.end(), distances.begin(),
                 [](float squared) { return std::sqrt(squared); });
  MetricValues values{};
  for (const Metric metric : kAllMetrics) {
    values.at(static_cast<size_t>(metric)) = ComputeOne<float>(metric, distances);
  }
  return values;
}

double ComputeMetric(Metric metric, std::span<const double> values) {
  return ComputeOne<double>(metric, values);
}

}  // namespace cohort
