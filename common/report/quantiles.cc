#include "common/report/quantiles.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <vector>

namespace cohort {
namespace {

constexpr double kFenceFactor = 4;
constexpr size_t kFewestForFence = 8;

std::vector<double> Known(std::span<const double> values) {
  std::vector<double> known;
  known.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(known),
               [](double value) { return !std::isnan(value); });
  return known;
}

// Reorders `values`.
double Quantile(std::vector<double>& values, double share) {
  const size_t rank = QuantileRank(values.size(), share);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                   values.end());
  return values[rank];
}

std::optional<double> FenceOf(double first_quartile, double third_quartile, double largest) {
  const double fence = third_quartile + kFenceFactor * (third_quartile - first_quartile);
  if (third_quartile <= first_quartile || largest <= fence) return std::nullopt;
  return fence;
}

}  // namespace

double ValueRange::Position(double value) const {
  if (std::isnan(value)) return value;
  if (!(high > low)) return 0.5;
  return (value - low) / (high - low);
}

ValueRange QuantileRange(std::span<const double> values, double low_share, double high_share) {
  std::vector<double> known = Known(values);
  if (known.empty()) return {};
  const double low = Quantile(known, low_share);
  return {low, Quantile(known, high_share)};
}

std::optional<double> FarFence(std::span<const double> values) {
  std::vector<double> known = Known(values);
  if (known.size() < kFewestForFence) return std::nullopt;
  const double first_quartile = Quantile(known, 0.25);
  const double third_quartile = Quantile(known, 0.75);
  return FenceOf(first_quartile, third_quartile, *std::max_element(known.begin(), known.end()));
}

std::optional<double> FarFenceOfSorted(std::span<const double> values) {
  if (values.size() < kFewestForFence) return std::nullopt;
  return FenceOf(values[QuantileRank(values.size(), 0.25)],
                 values[QuantileRank(values.size(), 0.75)], values.back());
}

size_t QuantileRank(size_t count, double share) {
  assert(count >= 1);
  return static_cast<size_t>(std::lround(share * static_cast<double>(count - 1)));
}

}  // namespace cohort
