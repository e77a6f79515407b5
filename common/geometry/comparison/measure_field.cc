#include "common/geometry/comparison/measure_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/field_totals.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/order_statistic.h"
#include "common/geometry/comparison/stable_log.h"

namespace cohort {
namespace {

/// One value of a weighted field.
struct Sample {
  float value;
  double weight;
  size_t index;
};

absl::Status CheckShare(double share, const char* name) {
  if (!(share >= 0 && share <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat(name, " ", share, " is not a share, 0 to 1"));
  }
  return absl::OkStatus();
}

absl::Status CheckValues(std::span<const float> distances) {
  if (distances.empty()) {
    return absl::InvalidArgumentError("the distance field has no value");
  }
  // Counted without a branch, which compilers turn into vectors.
  constexpr uint32_t kExponent = 0x7F800000;
  const auto is_finite = [](float value) {
    return (std::bit_cast<uint32_t>(value) & kExponent) != kExponent;
  };
  size_t finite = 0;
  for (const float distance : distances) {
    finite += is_finite(distance) ? 1 : 0;
  }
  if (finite == distances.size()) {
    return absl::OkStatus();
  }
  const auto bad = std::find_if_not(distances.begin(), distances.end(), is_finite);
  return absl::InvalidArgumentError(
      absl::StrCat("value ", bad - distances.begin(), " of the distance field is not finite"));
}

absl::Status NothingLeft(const FieldOptions& options, size_t count) {
  return absl::FailedPreconditionError(absl::StrCat("thresholds ", options.lower_share, " to ",
                                                    options.upper_share, " leave none of ", count,
                                                    " values"));
}

std::vector<float> WithSign(std::span<const float> distances, DistanceSign sign) {
  std::vector<float> values(distances.begin(), distances.end());
  if (sign == DistanceSign::kAbsolute) {
    std::transform(values.begin(), values.end(), values.begin(),
                   [](float value) { return std::abs(value); });
  }
  return values;
}

/// The values of the ranks first <= rank < end, end < n; see MeasureField for their order.
std::vector<float> ValuesBetween(std::span<const float> values, int64_t first, int64_t end) {
  std::vector<float> scratch(values.begin(), values.end());
  const float low = SelectRank(scratch, first);
  scratch.assign(values.begin(), values.end());
  const float high = SelectRank(scratch, end);
  if (low == high) {
    return std::vector<float>(static_cast<size_t>(end - first), low);
  }
  std::vector<float> window;
  int64_t up_to_low = 0;
  int64_t below_high = 0;
  for (const float value : values) {
    up_to_low += value <= low ? 1 : 0;
    below_high += value < high ? 1 : 0;
    if (value > low && value < high) {
      window.push_back(value);
    }
  }
  window.insert(window.end(), static_cast<size_t>(up_to_low - first), low);
  window.insert(window.end(), static_cast<size_t>(end - below_high), high);
  return window;
}

absl::StatusOr<std::vector<float>> ApplyThresholds(std::vector<float> values,
                                                   const FieldOptions& options) {
  if (!options.HasThresholds()) {
    return values;
  }
  if (options.upper_share <= options.lower_share) {
    return std::vector<float>{0.0F};
  }
  const auto n = static_cast<int64_t>(values.size());
  const int64_t first = PercentileRank(n, options.lower_share);
  const int64_t end = PercentileRank(n, options.upper_share);
  if (first == end) {
    return NothingLeft(options, values.size());
  }
  return ValuesBetween(values, first, end);
}

absl::StatusOr<std::vector<Sample>> SortedSamples(std::span<const float> distances,
                                                  std::span<const double> weights,
                                                  DistanceSign sign) {
  if (weights.size() != distances.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(weights.size(), " weights for ", distances.size(), " distances"));
  }
  std::vector<Sample> samples;
  for (size_t i = 0; i < distances.size(); ++i) {
    if (!(weights[i] >= 0 && std::isfinite(weights[i]))) {
      return absl::InvalidArgumentError(
          absl::StrCat("weight ", i, " is ", weights[i], ", not finite and >= 0"));
    }
    if (weights[i] > 0) {
      const float value = sign == DistanceSign::kAbsolute ? std::abs(distances[i]) : distances[i];
      samples.push_back({.value = value, .weight = weights[i], .index = i});
    }
  }
  if (samples.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("all ", distances.size(), " weights are 0: nothing to measure"));
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return a.value != b.value ? a.value < b.value : a.index < b.index;
  });
  return samples;
}

double TotalWeight(std::span<const Sample> samples) {
  double total = 0;
  for (const Sample& sample : samples) {
    total += sample.weight;
  }
  return total;
}

/// PercentileRank with weights: the last sample whose middle lies at or before the share q.
size_t WeightedRank(std::span<const Sample> samples, double q) {
  const double limit = q * TotalWeight(samples);
  double before = 0;
  size_t rank = 0;
  for (size_t i = 0; i < samples.size() && before + samples[i].weight / 2 <= limit; ++i) {
    rank = i;
    before += samples[i].weight;
  }
  return rank;
}

/// Totals whose count is 1: the sums are divided by the weight already.
FieldTotals WeightedTotals(std::span<const Sample> samples) {
  const double weight = TotalWeight(samples);
  FieldTotals totals;
  totals.count = 1;
  for (const Sample& sample : samples) {
    const double value{sample.value};
    totals.sum += sample.weight * value;
    totals.sum_squares += sample.weight * (value * value);
    totals.log_mean += sample.weight * StableLog(std::abs(value));
  }
  totals.sum /= weight;
  totals.sum_squares /= weight;
  totals.log_mean /= weight;
  for (const Sample& sample : samples) {
    const double deviation = double{sample.value} - totals.sum;
    totals.squared_deviations += sample.weight * (deviation * deviation);
  }
  totals.squared_deviations /= weight;
  totals.min = double{samples.front().value};
  totals.max = double{samples.back().value};
  return totals;
}

}  // namespace

absl::Status FieldOptions::Validate() const {
  COHORT_RETURN_IF_ERROR(CheckShare(percentile, "percentile"));
  COHORT_RETURN_IF_ERROR(CheckShare(lower_share, "lower threshold"));
  return CheckShare(upper_share, "upper threshold");
}

absl::StatusOr<FieldMeasure> MeasureField(std::span<const float> distances,
                                          const FieldOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  COHORT_RETURN_IF_ERROR(CheckValues(distances));
  COHORT_ASSIGN_OR_RETURN(const std::vector<float> values,
                          ApplyThresholds(WithSign(distances, options.sign), options));
  DistanceScratch scratch;
  const DistanceSummary summary = MeasureDistances(values, options.sign, scratch);
  const float percentile = SelectPercentile(values, summary.sketch, options.percentile, scratch);
  return FieldMeasure{.metrics = summary.metrics,
                      .percentile = double{std::abs(percentile)},
                      .count = static_cast<int64_t>(values.size())};
}

absl::StatusOr<FieldMeasure> MeasureWeightedField(std::span<const float> distances,
                                                  std::span<const double> weights,
                                                  const FieldOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  COHORT_RETURN_IF_ERROR(CheckValues(distances));
  COHORT_ASSIGN_OR_RETURN(std::vector<Sample> sorted,
                          SortedSamples(distances, weights, options.sign));
  std::span<const Sample> samples = sorted;
  if (options.HasThresholds()) {
    if (options.upper_share <= options.lower_share) {
      sorted = {Sample{.value = 0, .weight = 1, .index = 0}};
      samples = sorted;
    } else {
      const size_t first = WeightedRank(samples, options.lower_share);
      const size_t end = WeightedRank(samples, options.upper_share);
      if (first == end) {
        return NothingLeft(options, samples.size());
      }
      samples = samples.subspan(first, end - first);
    }
  }
  FieldMeasure measure{.metrics = MetricsOfTotals(WeightedTotals(samples)),
                       .percentile = 0,
                       .count = static_cast<int64_t>(samples.size())};
  const auto percentile = [samples](double q) {
    return double{std::abs(samples[WeightedRank(samples, q)].value)};
  };
  measure.metrics.at(static_cast<size_t>(Metric::kPercentile75)) = percentile(0.75);
  measure.percentile = percentile(options.percentile);
  return measure;
}

}  // namespace cohort
