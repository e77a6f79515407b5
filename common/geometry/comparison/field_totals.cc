#include "common/geometry/comparison/field_totals.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/geometry/comparison/stable_log.h"

namespace cohort {
namespace {

double GeometricMean(const FieldTotals& totals, double mean) {
  if (totals.min < 0) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (totals.min == 0) {
    return 0;
  }
  return std::clamp(StableExp(totals.log_mean), totals.min, mean);
}

}  // namespace

MetricValues MetricsOfTotals(const FieldTotals& totals) {
  assert(totals.count > 0 && totals.min <= totals.max);
  const auto n = static_cast<double>(totals.count);
  const double mean = std::clamp(totals.sum / n, totals.min, totals.max);
  const double largest = std::max(-totals.min, totals.max);
  MetricValues values{};
  const auto set = [&values](Metric metric, double value) {
    values.at(static_cast<size_t>(metric)) = value;
  };
  set(Metric::kRms, std::clamp(std::sqrt(totals.sum_squares / n), std::abs(mean), largest));
  set(Metric::kMean, mean);
  set(Metric::kGeometricMean, GeometricMean(totals, mean));
  set(Metric::kMin, totals.min);
  set(Metric::kMax, totals.max);
  set(Metric::kVariance, totals.squared_deviations / n);
  return values;
}

double LogMeanOfProduct(std::span<const double> mantissas,
                        std::span<const int64_t> exponents,
                        int64_t count) {
  double product = 1;
  int64_t exponent = 0;
  for (size_t lane = 0; lane < mantissas.size(); ++lane) {
    int shift = 0;
    product = std::frexp(product * mantissas[lane], &shift);
    exponent += exponents[lane] + shift;
  }
  constexpr double kLn2 = 0x1.62e42fefa39efp-1;
  return (static_cast<double>(exponent) * kLn2 + StableLog(product)) / static_cast<double>(count);
}

}  // namespace cohort
