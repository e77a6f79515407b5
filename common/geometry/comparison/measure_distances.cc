#include "common/geometry/comparison/measure_distances.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/geometry/comparison/order_statistic.h"

namespace cohort {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

FieldLanes EmptyLanes() {
  FieldLanes lanes{};
  std::fill(std::begin(lanes.mantissa), std::end(lanes.mantissa), 1.0);
  std::fill(std::begin(lanes.min), std::end(lanes.min), kInfinity);
  std::fill(std::begin(lanes.max), std::end(lanes.max), -kInfinity);
  std::fill(std::begin(lanes.min_absolute), std::end(lanes.min_absolute), kInfinity);
  return lanes;
}

double SumLanes(std::span<const double> lanes) {
  double sum = 0;
  for (const double lane : lanes) {
    sum += lane;
  }
  return sum;
}

/// The values of the last, incomplete row: the same operations as in the kernels, one by one.
void AccumulateTail(FieldInput input,
                    std::span<const float> values,
                    std::span<float> distances,
                    FieldLanes& lanes) {
  for (size_t lane = 0; lane < values.size(); ++lane) {
    const float d = input == FieldInput::kSquared ? std::sqrt(values[lane]) : values[lane];
    const float a = input == FieldInput::kSigned ? std::abs(d) : d;
    distances[lane] = d;
    lanes.sum[lane] += double{d};
    lanes.sum_squares[lane] += double{d} * double{d};
    lanes.min[lane] = std::min(lanes.min[lane], d);
    lanes.max[lane] = std::max(lanes.max[lane], d);
    if (input == FieldInput::kSigned) {
      lanes.sum_absolute[lane] += double{a};
      lanes.min_absolute[lane] = std::min(lanes.min_absolute[lane], a);
    }
    int shift = 0;
    lanes.mantissa[lane] = 2 * std::frexp(lanes.mantissa[lane] * double{a}, &shift);
    lanes.exponent[lane] += shift - 1;
  }
}

FieldTotals Total(FieldInput input, const FieldLanes& lanes, int64_t count) {
  FieldTotals totals;
  totals.count = count;
  totals.sum = SumLanes(lanes.sum);
  totals.sum_squares = SumLanes(lanes.sum_squares);
  totals.min = *std::min_element(std::begin(lanes.min), std::end(lanes.min)) + 0.0;
  totals.max = *std::max_element(std::begin(lanes.max), std::end(lanes.max)) + 0.0;
  totals.sum_absolute = totals.sum;
  totals.min_absolute = totals.min;
  if (input == FieldInput::kSigned) {
    totals.sum_absolute = SumLanes(lanes.sum_absolute);
    totals.min_absolute =
        *std::min_element(std::begin(lanes.min_absolute), std::end(lanes.min_absolute)) + 0.0;
  }
  totals.log_mean = totals.min_absolute == 0
                        ? -std::numeric_limits<double>::infinity()
                        : LogMeanOfProduct(lanes.mantissa, lanes.exponent, count);
  return totals;
}

/// The bin of one distance, as the kernels find it.
int64_t BinOf(float distance, const FieldBinning& binning) {
  const auto first = static_cast<float>(binning.first_bin);
  const float bin = std::floor(distance * binning.inverse_width);
  return static_cast<int64_t>(std::clamp(bin, first, first + (kFieldBins - 1)) - first);
}

/// Fills the bins and the sum of squared deviations.
void CountBins(const FieldKernels& kernels,
               std::span<const float> distances,
               DistanceSketch& sketch) {
  alignas(64) std::array<uint32_t, size_t{kFieldTables} * kFieldBins> tables{};
  FieldBinning binning{.inverse_width = static_cast<float>(1 / sketch.bin_width),
                       .first_bin = sketch.FirstBin(),
                       .mean = sketch.totals.sum / static_cast<double>(sketch.totals.count),
                       .deviation = {}};
  const size_t rows = distances.size() / kFieldLanes;
  kernels.count(distances.data(), static_cast<int64_t>(rows), binning, tables.data());
  const std::span<const float> tail = distances.subspan(rows * kFieldLanes);
  for (size_t lane = 0; lane < tail.size(); ++lane) {
    ++tables.at(static_cast<size_t>(BinOf(tail[lane], binning)));
    const double deviation = double{tail[lane]} - binning.mean;
    binning.deviation[lane] += deviation * deviation;
  }
  sketch.totals.squared_deviations = SumLanes(binning.deviation);
  for (size_t bin = 0; bin < kFieldBins; ++bin) {
    for (size_t table = 0; table < kFieldTables; ++table) {
      sketch.bins.at(bin) += tables.at(table * kFieldBins + bin);
    }
  }
}

/// The histogram leaves one bin in question; its values are picked and the rank is selected there.
float Select(const FieldKernels& kernels,
             std::span<const float> distances,
             const DistanceSketch& sketch,
             double q,
             DistanceScratch& scratch) {
  int64_t rank = PercentileRank(sketch.totals.count, q);
  size_t bin = 0;
  while (rank >= int64_t{sketch.bins.at(bin)}) {
    rank -= int64_t{sketch.bins.at(bin++)};
  }
  const double low_edge = (sketch.FirstBin() + static_cast<double>(bin)) * sketch.bin_width;
  const float low = bin == 0 ? -kInfinity : static_cast<float>(low_edge);
  const float high =
      bin == kSketchBins - 1 ? kInfinity : static_cast<float>(low_edge + sketch.bin_width);
  scratch.candidates.resize(size_t{sketch.bins.at(bin)} + kFieldLanes);
  const size_t rows = distances.size() / kFieldLanes;
  auto count = static_cast<size_t>(kernels.pick(distances.data(), static_cast<int64_t>(rows), low,
                                                high, scratch.candidates.data()));
  for (const float distance : distances.subspan(rows * kFieldLanes)) {
    if (distance >= low && distance < high) {
      scratch.candidates.at(count++) = distance;
    }
  }
  assert(count == sketch.bins.at(bin));
  return SelectRank(std::span(scratch.candidates).first(count), rank);
}

}  // namespace

DistanceSummary MeasureWith(const FieldKernels& kernels,
                            FieldInput input,
                            std::span<const float> values,
                            DistanceScratch& scratch) {
  assert(!values.empty());
  scratch.distances.resize(values.size());
  const std::span<float> distances = scratch.distances;
  FieldLanes lanes = EmptyLanes();
  const size_t rows = values.size() / kFieldLanes;
  kernels.accumulate(input, values.data(), static_cast<int64_t>(rows), distances.data(), lanes);
  AccumulateTail(input, values.subspan(rows * kFieldLanes), distances.subspan(rows * kFieldLanes),
                 lanes);

  DistanceSummary summary;
  DistanceSketch& sketch = summary.sketch;
  sketch.sign = input == FieldInput::kSigned ? DistanceSign::kSigned : DistanceSign::kAbsolute;
  sketch.totals = Total(input, lanes, static_cast<int64_t>(values.size()));
  const double mean_square = sketch.totals.sum_squares / static_cast<double>(sketch.totals.count);
  sketch.bin_width = SketchBinWidth(sketch.sign, std::max(-sketch.totals.min, sketch.totals.max),
                                    std::sqrt(mean_square));
  CountBins(kernels, distances, sketch);
  summary.metrics = MetricsOfTotals(sketch.totals);
  summary.metrics.at(static_cast<size_t>(Metric::kPercentile75)) =
      double{std::abs(Select(kernels, distances, sketch, 0.75, scratch))};
  return summary;
}

DistanceSummary MeasureSquaredDistances(std::span<const float> squared_distances,
                                        DistanceScratch& scratch) {
  return MeasureWith(BestFieldKernels(), FieldInput::kSquared, squared_distances, scratch);
}

DistanceSummary MeasureDistances(std::span<const float> distances,
                                 DistanceSign sign,
                                 DistanceScratch& scratch) {
  const FieldInput input =
      sign == DistanceSign::kSigned ? FieldInput::kSigned : FieldInput::kAbsolute;
  return MeasureWith(BestFieldKernels(), input, distances, scratch);
}

float SelectPercentile(std::span<const float> distances,
                       const DistanceSketch& sketch,
                       double q,
                       DistanceScratch& scratch) {
  return Select(BestFieldKernels(), distances, sketch, q, scratch);
}

}  // namespace cohort
