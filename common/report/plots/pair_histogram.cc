#include <algorithm>
#include <array>
#include <cstdint>

#include <absl/strings/str_cat.h>

#include "common/report/decimal.h"
#include "common/report/plot_style.h"
#include "common/report/plots/plots.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr Box kArea = {76, 16, 620, 280};
constexpr double kPageWidth = 716;
constexpr double kBelow = 56;
constexpr double kLegendRow = 17;
// As in histogram.png: blue and vermilion of Okabe and Ito.
constexpr Rgb kSameColor = {213, 94, 0};
constexpr Rgb kDifferentColor = {0, 114, 178};

struct Series {
  std::string name;
  Rgb color;
  std::span<const double> values;  // Ascending.
  std::vector<int64_t> counts = {};
  double whole = 1;  // What the bars are shares of: 1, or the pairs of the series.

  [[nodiscard]] double Height(size_t bin) const { return static_cast<double>(counts[bin]) / whole; }
};

std::vector<Series> SeriesOf(const PairValues& pairs, const Bins& bins) {
  std::vector<Series> series;
  if (pairs.by_person) {
    series.push_back({"same person", kSameColor, pairs.same});
    series.push_back({"different people", kDifferentColor, pairs.different});
  } else {
    series.push_back({"all pairs", kDifferentColor, pairs.different});
  }
  for (Series& one : series) {
    one.counts = CountInBins(one.values, bins);
    if (pairs.by_person && !one.values.empty()) one.whole = static_cast<double>(one.values.size());
  }
  return series;
}

double Tallest(const std::vector<Series>& series) {
  double tallest = 0;
  for (const Series& one : series) {
    for (size_t bin = 0; bin < one.counts.size(); ++bin) {
      tallest = std::max(tallest, one.Height(bin));
    }
  }
  return tallest;
}

// No fractions of pairs.
int TicksUpTo(double tallest, const PairValues& pairs) {
  return pairs.by_person || tallest >= 6 ? 6 : static_cast<int>(tallest) + 1;
}

void DrawBars(const Series& one, const Bins& bins, const SvgArea& area, SvgPage& page) {
  for (size_t bin = 0; bin < one.counts.size(); ++bin) {
    if (one.counts[bin] == 0) continue;
    const double low = bins.first + bins.width * static_cast<double>(bin);
    const Spot top = area.At(low, one.Height(bin));
    const Spot end = area.At(low + bins.width, 0);
    page.Fill({top.x + 0.4, top.y, end.x - top.x - 0.8, end.y - top.y}, one.color, 0.5,
              absl::StrCat(one.name, ", ", ReadableDecimal(low, 3), " to ",
                           ReadableDecimal(low + bins.width, 3), ": ",
                           Counted(one.counts[bin], "pair", "pairs")));
  }
}

void DrawLegend(const std::vector<Series>& series,
                const MatrixDescription& description,
                const SvgArea& area,
                SvgPage& page) {
  double y = kArea.y + kArea.height + kBelow;
  for (const Series& one : series) {
    const double median = MedianOfSorted(one.values);
    if (!one.values.empty()) {
      const double x = area.At(median, 0).x;
      page.Line(std::array<Spot, 2>{{{x, kArea.y}, {x, kArea.y + kArea.height}}},
                {one.color, 1.3, {5, 4}});
    }
    page.Fill({kArea.x, y - 6, 16, 12}, one.color, 0.5);
    page.Text({kArea.x + 24, y},
              absl::StrCat(one.name, ": ", Counted(std::ssize(one.values), "pair", "pairs"),
                           one.values.empty()
                               ? ""
                               : ", median " + WithUnit(ReadableDecimal(median, 3), description) +
                                     " (dashed)"),
              kTickStyle, Anchor::kStart);
    y += kLegendRow;
  }
}

}  // namespace

std::string PairHistogramSvg(const PairValues& pairs, const MatrixDescription& description) {
  if (pairs.same.empty() && pairs.different.empty()) return "";
  const Bins bins = ChooseBins(pairs);
  const std::vector<Series> series = SeriesOf(pairs, bins);
  const double high = bins.first + bins.width * bins.count;
  const double tallest = Tallest(series);
  const SvgArea area{kArea,
                     {.title = ValueTitle(description), .range = {bins.first, high}, .ticks = 10},
                     {.title = pairs.by_person ? "share of the pairs" : "pairs",
                      .range = {0, 1.05 * tallest},
                      .ticks = TicksUpTo(tallest, pairs),
                      .numbers = pairs.by_person ? AxisNumbers::kPercent : AxisNumbers::kPlain}};
  SvgPage page(kPageWidth,
               kArea.y + kArea.height + kBelow + kLegendRow * static_cast<double>(series.size()),
               "Histogram: " + ValueTitle(description) + " of the pairs");
  DrawAxes(area, page);
  for (const Series& one : series) DrawBars(one, bins, area, page);
  DrawLegend(series, description, area, page);
  return page.Svg();
}

}  // namespace cohort
