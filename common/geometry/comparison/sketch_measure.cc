#include "common/geometry/comparison/sketch_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/order_statistic.h"
#include "common/geometry/comparison/stable_log.h"

namespace cohort {
namespace {

struct Interval {
  double low = 0;
  double high = 0;
  [[nodiscard]] double Middle() const { return low + (high - low) / 2; }
};

Interval Intersect(const Interval& a, const Interval& b) {
  const Interval both{std::max(a.low, b.low), std::min(a.high, b.high)};
  // Two true intervals meet; where rounding leaves a gap, it is the value.
  return both.low <= both.high ? both : Interval{both.high, both.low};
}

/// `count` values somewhere in `range`.
struct Bin {
  Interval range;
  int64_t count;
};

/// The field as the sketch knows it: bins in ascending order, none empty, and exact totals.
struct Bins {
  std::vector<Bin> bins;
  FieldTotals totals;
};

Interval RangeOf(const DistanceSketch& sketch, int bin) {
  const double low = (sketch.FirstBin() + bin) * sketch.bin_width;
  const Interval range{bin == 0 ? sketch.totals.min : low,
                       bin == kSketchBins - 1 ? sketch.totals.max : low + sketch.bin_width};
  return {std::max(range.low, sketch.totals.min), std::min(range.high, sketch.totals.max)};
}

Bins AsCounted(const DistanceSketch& sketch) {
  Bins result{.bins = {}, .totals = sketch.totals};
  for (int bin = 0; bin < kSketchBins; ++bin) {
    const auto count = int64_t{sketch.bins.at(static_cast<size_t>(bin))};
    if (count > 0) {
      result.bins.push_back({RangeOf(sketch, bin), count});
    }
  }
  return result;
}

/// |d| of signed values: the bins below zero mirrored onto those above.
Bins Folded(const DistanceSketch& sketch) {
  Bins result{.bins = {}, .totals = sketch.totals};
  FieldTotals& totals = result.totals;
  const auto n = static_cast<double>(totals.count);
  // sum (|d| - m)^2 from sum (d - mean)^2: the mean squares of both are the same.
  const double mean = totals.sum / n;
  const double absolute_mean = totals.sum_absolute / n;
  totals.squared_deviations = std::max(
      0.0, totals.squared_deviations + n * (mean - absolute_mean) * (mean + absolute_mean));
  totals.sum = totals.sum_absolute;
  totals.max = std::max(-sketch.totals.min, sketch.totals.max);
  totals.min = totals.min_absolute;
  constexpr size_t kHalf = kSketchBins / 2;
  for (size_t bin = 0; bin < kHalf; ++bin) {
    const auto above = int64_t{sketch.bins.at(kHalf + bin)};
    const auto below = int64_t{sketch.bins.at(kHalf - 1 - bin)};
    if (above + below == 0) {
      continue;
    }
    const double low = static_cast<double>(bin) * sketch.bin_width;
    const double high = bin == kHalf - 1 ? totals.max : low + sketch.bin_width;
    result.bins.push_back({{std::max(low, totals.min), std::min(high, totals.max)}, above + below});
  }
  return result;
}

/// Where the value of a rank lies.
Interval RankInterval(const Bins& field, int64_t rank) {
  if (rank == 0) {
    return {field.totals.min, field.totals.min};
  }
  if (rank == field.totals.count - 1) {
    return {field.totals.max, field.totals.max};
  }
  for (const Bin& bin : field.bins) {
    if (rank < bin.count) {
      return bin.range;
    }
    rank -= bin.count;
  }
  return {field.totals.max, field.totals.max};
}

/// The value of a rank, interpolated as if the values of its bin were spread evenly.
double RankValue(const Bins& field, int64_t rank) {
  const Interval range = RankInterval(field, rank);
  for (const Bin& bin : field.bins) {
    if (rank < bin.count) {
      const double share = (static_cast<double>(rank) + 0.5) / static_cast<double>(bin.count);
      return range.low + (range.high - range.low) * share;
    }
    rank -= bin.count;
  }
  return range.Middle();
}

/// A number and how far it can be off.
struct Answer {
  double value = 0;
  double bound = 0;
};

Answer Of(const Interval& interval) {
  const double value = interval.Middle();
  return {value, std::max(value - interval.low, interval.high - value)};
}

/// |v| of the value v of a rank: no farther off than v.
Answer OfRank(const Bins& field, int64_t rank) {
  const Interval range = RankInterval(field, rank);
  const double value = RankValue(field, rank);
  return {std::abs(value), std::max(value - range.low, range.high - value)};
}

/// The parts of the bins that the ranks first <= rank < end fall into, and the parts outside.
struct Cut {
  std::vector<Bin> inside;
  std::vector<Bin> outside;
};

Cut CutAt(const Bins& field, int64_t first, int64_t end) {
  Cut cut;
  int64_t before = 0;
  for (const Bin& bin : field.bins) {
    const int64_t after = before + bin.count;
    const int64_t inside = std::max<int64_t>(0, std::min(end, after) - std::max(first, before));
    if (inside > 0) {
      cut.inside.push_back({bin.range, inside});
    }
    if (inside < bin.count) {
      cut.outside.push_back({bin.range, bin.count - inside});
    }
    before = after;
  }
  return cut;
}

/// Sum over the values inside of a function that is between the ends of `map(range)` on a range:
/// from the bins inside, and from the exact total less the bins outside.
template <typename Map>
Interval SumInside(const Cut& cut, double total, Map map) {
  Interval inside;
  Interval rest{total, total};
  for (const Bin& bin : cut.inside) {
    const Interval range = map(bin.range);
    inside.low += static_cast<double>(bin.count) * range.low;
    inside.high += static_cast<double>(bin.count) * range.high;
  }
  for (const Bin& bin : cut.outside) {
    const Interval range = map(bin.range);
    rest.low -= static_cast<double>(bin.count) * range.high;
    rest.high -= static_cast<double>(bin.count) * range.low;
  }
  // Infinities (ln 0) make the second one say nothing.
  return std::isfinite(rest.low) && std::isfinite(rest.high) ? Intersect(inside, rest) : inside;
}

Interval Squares(const Interval& range) {
  const double low = range.low * range.low;
  const double high = range.high * range.high;
  const bool has_zero = range.low <= 0 && range.high >= 0;
  return {has_zero ? 0 : std::min(low, high), std::max(low, high)};
}

/// Square root of the mean of (d - center)^2 with every d in the middle of its bin, and how far it
/// can be off: the triangle inequality in n dimensions. Same for the standard deviation.
Answer MiddleDeviation(const Cut& cut, double center, double count) {
  double sum = 0;
  double errors = 0;
  for (const Bin& bin : cut.inside) {
    const double deviation = bin.range.Middle() - center;
    const double error = (bin.range.high - bin.range.low) / 2;
    sum += static_cast<double>(bin.count) * deviation * deviation;
    errors += static_cast<double>(bin.count) * error * error;
  }
  return {std::sqrt(sum / count), std::sqrt(errors / count)};
}

double MiddleMean(const Cut& cut, double count) {
  double sum = 0;
  for (const Bin& bin : cut.inside) {
    sum += static_cast<double>(bin.count) * bin.range.Middle();
  }
  return sum / count;
}

Interval Around(const Answer& answer) {
  return {std::max(0.0, answer.value - answer.bound), answer.value + answer.bound};
}

Interval WindowVariance(const Cut& cut, const Interval& mean, const Interval& square, double n) {
  const Interval by_middles = Around(MiddleDeviation(cut, MiddleMean(cut, n), n));
  const Interval squared_mean = Squares(mean);
  return Intersect({by_middles.low * by_middles.low, by_middles.high * by_middles.high},
                   {std::max(0.0, square.low - squared_mean.high),
                    std::max(0.0, square.high - squared_mean.low)});
}

Answer WindowGeometricMean(const Bins& field, const Cut& cut, int64_t first, double n) {
  // No bin holds values on both sides of zero.
  if (cut.inside.front().range.low < 0) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  if (field.totals.min == 0 && first == 0) {
    return {0, 0};
  }
  const double total = field.totals.min < 0
                           ? -std::numeric_limits<double>::infinity()
                           : field.totals.log_mean * static_cast<double>(field.totals.count);
  const Interval sum = SumInside(cut, total, [](const Interval& range) {
    return Interval{StableLog(std::max(0.0, range.low)), StableLog(std::max(0.0, range.high))};
  });
  return Of({StableExp(sum.low / n), StableExp(sum.high / n)});
}

void Set(SketchMeasure& measure, Metric metric, const Answer& answer) {
  measure.value.metrics.at(static_cast<size_t>(metric)) = answer.value;
  measure.bounds.at(static_cast<size_t>(metric)) = answer.bound;
}

/// The metrics of the ranks first <= rank < end.
SketchMeasure MeasureWindow(const Bins& field, int64_t first, int64_t end) {
  const Cut cut = CutAt(field, first, end);
  const auto n = static_cast<double>(end - first);
  const Interval sum =
      SumInside(cut, field.totals.sum, [](const Interval& range) { return range; });
  const Interval squares = SumInside(cut, field.totals.sum_squares, Squares);
  const Interval mean{sum.low / n, sum.high / n};
  const Interval square{std::max(0.0, squares.low / n), std::max(0.0, squares.high / n)};
  const Interval rms = Intersect({std::sqrt(square.low), std::sqrt(square.high)},
                                 Around(MiddleDeviation(cut, 0, n)));
  SketchMeasure measure;
  Set(measure, Metric::kMean, Of(mean));
  Set(measure, Metric::kRms, Of(rms));
  Set(measure, Metric::kVariance, Of(WindowVariance(cut, mean, square, n)));
  Set(measure, Metric::kGeometricMean, WindowGeometricMean(field, cut, first, n));
  Set(measure, Metric::kMin, Of(RankInterval(field, first)));
  Set(measure, Metric::kMax, Of(RankInterval(field, end - 1)));
  return measure;
}

/// Fills in the percentiles of the ranks first <= rank < end.
void SetPercentiles(const Bins& field, int64_t first, int64_t end, double q, SketchMeasure& out) {
  const int64_t count = end - first;
  Set(out, Metric::kPercentile75, OfRank(field, first + PercentileRank(count, 0.75)));
  const Answer percentile = OfRank(field, first + PercentileRank(count, q));
  out.value.percentile = percentile.value;
  out.percentile_bound = percentile.bound;
  out.value.count = count;
}

}  // namespace

absl::StatusOr<SketchMeasure> MeasureSketch(const DistanceSketch& sketch,
                                            const FieldOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (options.sign == DistanceSign::kSigned && sketch.sign == DistanceSign::kAbsolute) {
    return absl::FailedPreconditionError(
        "signed metrics are asked, but the sketch is of absolute distances");
  }
  const Bins field = options.sign == sketch.sign ? AsCounted(sketch) : Folded(sketch);
  const int64_t n = field.totals.count;
  SketchMeasure measure;
  if (!options.HasThresholds()) {
    measure.value.metrics = MetricsOfTotals(field.totals);
    SetPercentiles(field, 0, n, options.percentile, measure);
    return measure;
  }
  if (options.upper_share <= options.lower_share) {
    measure.value.count = 1;  // The single value 0.
    return measure;
  }
  const int64_t first = PercentileRank(n, options.lower_share);
  const int64_t end = PercentileRank(n, options.upper_share);
  if (first == end) {
    return absl::FailedPreconditionError(absl::StrCat("thresholds ", options.lower_share, " to ",
                                                      options.upper_share, " leave none of ", n,
                                                      " values"));
  }
  measure = MeasureWindow(field, first, end);
  SetPercentiles(field, first, end, options.percentile, measure);
  return measure;
}

}  // namespace cohort
