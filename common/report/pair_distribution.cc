#include "common/report/pair_distribution.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/report/axis_ticks.h"
#include "common/report/quantiles.h"

namespace cohort {
namespace {

// Of the rule's result; a nice step differs from it by a factor of 0.6 to 1.6.
constexpr double kMaxBins = 40;
constexpr double kMinBins = 15;
constexpr double kHalfOfNiceStep = 1.6;
// Bin width around a constant, relative to it.
constexpr double kConstantWidth = 0.02;

void AddPair(double value, const std::string& a, const std::string& b, PairValues& pairs) {
  if (std::isnan(value)) {
    ++pairs.missing;
  } else if (pairs.by_person && (a.empty() || b.empty())) {
    ++pairs.unknown;
  } else if (pairs.by_person && a == b) {
    pairs.same.push_back(value);
  } else {
    pairs.different.push_back(value);
  }
}

// Where a class ends for the eye.
double End(std::span<const double> sorted) {
  if (sorted.empty()) return -std::numeric_limits<double>::infinity();
  return FarFenceOfSorted(sorted).value_or(sorted.back());
}

// Element `rank` of two ascending lists together, without making one of them.
double RankedOfBoth(std::span<const double> a, std::span<const double> b, size_t rank) {
  // How many of a's are among the `rank` before it.
  size_t low = rank > b.size() ? rank - b.size() : 0;
  size_t high = std::min(rank, a.size());
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (a[middle] < b[rank - middle - 1]) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  const size_t of_b = rank - low;
  if (low == a.size()) return b[of_b];
  return of_b == b.size() ? a[low] : std::min(a[low], b[of_b]);
}

int64_t CountFrom(double least, std::span<const double> sorted) {
  return sorted.end() - std::lower_bound(sorted.begin(), sorted.end(), least);
}

}  // namespace

PairValues CollectPairs(const MatrixView& matrix,
                        Symmetrization symmetrization,
                        std::span<const std::string> persons) {
  const Eigen::Index count = matrix.values.rows();
  assert(persons.empty() || std::ssize(persons) == count);
  PairValues pairs;
  pairs.by_person =
      std::any_of(persons.begin(), persons.end(), [](const auto& p) { return !p.empty(); });
  const bool is_directed = symmetrization == Symmetrization::kDirected;
  const auto pair_count =
      static_cast<size_t>(count) * static_cast<size_t>(std::max<Eigen::Index>(count - 1, 0));
  pairs.different.reserve(is_directed ? pair_count : pair_count / 2);
  const std::string nobody;
  const auto person = [&](Eigen::Index i) -> const std::string& {
    return pairs.by_person ? persons[static_cast<size_t>(i)] : nobody;
  };
  for (Eigen::Index row = 0; row < count; ++row) {
    const Eigen::Index begin = is_directed ? 0 : row + 1;
    for (Eigen::Index column = begin; column < count; ++column) {
      if (row != column) AddPair(matrix.values(row, column), person(row), person(column), pairs);
    }
  }
  std::sort(pairs.same.begin(), pairs.same.end());
  std::sort(pairs.different.begin(), pairs.different.end());
  return pairs;
}

double MedianOfSorted(std::span<const double> sorted) {
  if (sorted.empty()) return 0;
  const size_t middle = sorted.size() / 2;
  if (sorted.size() % 2 == 1) return sorted[middle];
  return (sorted[middle - 1] + sorted[middle]) / 2;
}

Bins ChooseBins(const PairValues& pairs) {
  const size_t count = pairs.same.size() + pairs.different.size();
  if (count == 0) return {0, 0.1, 10};
  const auto quantile = [&](double share) {
    return RankedOfBoth(pairs.same, pairs.different, QuantileRank(count, share));
  };
  const ValueRange range = {quantile(0),
                            std::min(quantile(1), std::max(End(pairs.same), End(pairs.different)))};
  const ValueRange quartiles = {quantile(0.25), quantile(0.75)};
  const double extent = range.high - range.low;
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  if (extent <= 1e-9 * magnitude) {
    const double width = magnitude > 0 ? kConstantWidth * magnitude : 0.1;
    return {range.low - 5.5 * width, width, 11};
  }
  const double rule = 2 * (quartiles.high - quartiles.low) / std::cbrt(static_cast<double>(count));
  Bins bins;
  bins.width = NiceStep(std::clamp(rule, extent / kMaxBins, extent / kMinBins) / kHalfOfNiceStep);
  const double first = std::floor(range.low / bins.width);
  bins.first = first * bins.width;
  bins.count = static_cast<int>(std::floor(range.high / bins.width) - first) + 1;
  const double end = (first + bins.count) * bins.width;
  bins.beyond = CountFrom(end, pairs.same) + CountFrom(end, pairs.different);
  return bins;
}

std::vector<int64_t> CountInBins(std::span<const double> values, const Bins& bins) {
  std::vector<int64_t> counts(static_cast<size_t>(bins.count), 0);
  for (const double value : values) {
    const double place = std::floor((value - bins.first) / bins.width);
    ++counts[static_cast<size_t>(std::clamp(place, 0.0, bins.count - 1.0))];
  }
  return counts;
}

}  // namespace cohort
