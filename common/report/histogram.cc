#include "common/report/histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/status_macros.h"
#include "common/report/axis_ticks.h"
#include "common/report/canvas.h"
#include "common/report/decimal.h"
#include "common/report/pair_distribution.h"
#include "common/report/plot_style.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr double kWidth = 720;
constexpr double kPlotHeight = 320;
constexpr double kLeft = 76;
constexpr double kLineHeight = 18;
constexpr double kBelow = 54;  // Tick labels and axis title.

// Blue and vermilion of Okabe and Ito: told apart with any colour vision.
constexpr Rgb kSameColor = {213, 94, 0};
constexpr Rgb kDifferentColor = {0, 114, 178};
constexpr Rgb kGridColor = {222, 222, 222};
constexpr double kOpacity = 0.45;

// What the bars count.
enum class HeightUnit { kPairs, kPercent };

struct Series {
  std::string name;
  Rgb color;
  std::span<const double> values;  // Ascending.
  std::vector<double> heights;     // One per bin.
};

struct Plot {
  std::vector<Series> series;
  std::vector<std::string> notes;
  HeightUnit height_unit = HeightUnit::kPairs;
  std::string height_title;
  Bins bins;
  Box area;
  double low = 0;  // Of the horizontal axis.
  double high = 1;
  double top_height = 1;  // Of the vertical axis.
  double page_height = 0;

  [[nodiscard]] double X(double value) const {
    return area.x + (value - low) / (high - low) * area.width;
  }
  [[nodiscard]] double Y(double height) const {
    return area.y + (1 - height / top_height) * area.height;
  }
};

std::string PairWord(int64_t count, const MatrixDescription& description) {
  const bool is_directed = description.symmetrization == Symmetrization::kDirected;
  return is_directed ? Counted(count, "directed pair", "directed pairs")
                     : Counted(count, "pair", "pairs");
}

void SetHeights(const PairValues& pairs, const MatrixDescription& description, Plot& plot) {
  double highest = 0;
  for (Series& series : plot.series) {
    const double unit = pairs.by_person
                            ? 100.0 / static_cast<double>(std::max<size_t>(series.values.size(), 1))
                            : 1;
    for (const int64_t count : CountInBins(series.values, plot.bins)) {
      series.heights.push_back(static_cast<double>(count) * unit);
      highest = std::max(highest, series.heights.back());
    }
  }
  plot.height_unit = pairs.by_person ? HeightUnit::kPercent : HeightUnit::kPairs;
  plot.top_height = highest > 0 ? highest * 1.06 : 1;
  const bool is_directed = description.symmetrization == Symmetrization::kDirected;
  plot.height_title = pairs.by_person ? "share of the pairs in each class (%)"
                      : is_directed   ? "directed pairs"
                                      : "pairs";
}

void AddNotes(const PairValues& pairs, const MatrixDescription& description, Plot& plot) {
  if (plot.bins.beyond > 0) {
    const double largest = std::max(pairs.same.empty() ? 0 : pairs.same.back(),
                                    pairs.different.empty() ? 0 : pairs.different.back());
    plot.notes.push_back("The last bar also has " + PairWord(plot.bins.beyond, description) +
                         " beyond it, up to " + WithUnit(ReadableDecimal(largest, 3), description) +
                         ".");
  }
  if (pairs.missing > 0) {
    plot.notes.push_back("Not measured: " + PairWord(pairs.missing, description) + ".");
  }
  if (pairs.unknown > 0) {
    plot.notes.push_back(
        "Left out, because a person is not known: " + PairWord(pairs.unknown, description) + ".");
  }
}

Plot MakePlot(const PairValues& pairs, const MatrixDescription& description) {
  Plot plot;
  plot.bins = ChooseBins(pairs);
  plot.low = plot.bins.first;
  plot.high = plot.bins.first + plot.bins.count * plot.bins.width;
  if (pairs.by_person) {
    plot.series.push_back({"different people", kDifferentColor, pairs.different, {}});
    plot.series.push_back({"same person", kSameColor, pairs.same, {}});
  } else {
    plot.series.push_back({"all pairs", kDifferentColor, pairs.different, {}});
  }
  SetHeights(pairs, description, plot);
  AddNotes(pairs, description, plot);
  const double top = kTitlesEnd + static_cast<double>(plot.series.size()) * kLineHeight + 8;
  plot.area = {kLeft, top, kWidth - kLeft - kPlotMargin - 10, kPlotHeight};
  plot.page_height = top + kPlotHeight + kBelow + kPlotMargin / 2 +
                     static_cast<double>(plot.notes.size()) * kLineHeight;
  return plot;
}

void DrawAxes(const Plot& plot, const MatrixDescription& description, Canvas& canvas) {
  const Box& area = plot.area;
  const double bottom = area.y + area.height;
  const bool counts_pairs = plot.height_unit == HeightUnit::kPairs;
  const AxisTicks heights = NiceTicks(0, plot.top_height, 7);
  for (const double height : heights.values) {
    // Half a pair does not exist: counts have whole numbers only.
    if (counts_pairs && height != std::floor(height)) continue;
    const double y = plot.Y(height);
    canvas.Line(std::array<Spot, 2>{{{area.x, y}, {area.x + area.width, y}}}, {kGridColor, 0.75});
    const std::string text = counts_pairs ? FixedDecimal(height, 0) : heights.Text(height);
    canvas.Text({area.x - 7, y}, text, kTickStyle, Anchor::kEnd);
  }
  const AxisTicks values = NiceTicks(plot.low, plot.high, 11);
  for (const double value : values.values) {
    const double x = plot.X(value);
    canvas.Line(std::array<Spot, 2>{{{x, bottom}, {x, bottom + kTickLength}}}, {kInk, 0.75});
    canvas.Text({x, bottom + 13}, values.Text(value), kTickStyle, Anchor::kMiddle);
  }
  canvas.Text({area.x + area.width / 2, bottom + 36}, ValueTitle(description), kAxisStyle,
              Anchor::kMiddle);
  canvas.VerticalText({kPlotMargin + 4, area.y + area.height / 2}, plot.height_title, kAxisStyle,
                      Anchor::kMiddle);
}

// Outline of the bars as one line from the axis to the axis.
std::vector<Spot> Outline(const Series& series, const Plot& plot) {
  std::vector<Spot> outline = {{plot.X(plot.low), plot.Y(0)}};
  for (size_t i = 0; i < series.heights.size(); ++i) {
    const double left = plot.low + static_cast<double>(i) * plot.bins.width;
    outline.push_back({plot.X(left), plot.Y(series.heights[i])});
    outline.push_back({plot.X(left + plot.bins.width), plot.Y(series.heights[i])});
  }
  outline.push_back({plot.X(plot.high), plot.Y(0)});
  return outline;
}

void DrawSeries(const Series& series, const Plot& plot, Canvas& canvas) {
  if (series.values.empty()) return;
  const std::vector<Spot> outline = Outline(series, plot);
  canvas.FillShape(outline, series.color, kOpacity);
  canvas.Line(outline, {series.color, 1.25});
}

void DrawMedian(const Series& series, const Plot& plot, Canvas& canvas) {
  if (series.values.empty()) return;
  const double x = plot.X(MedianOfSorted(series.values));
  canvas.Line(std::array<Spot, 2>{{{x, plot.area.y - 4}, {x, plot.area.y + plot.area.height}}},
              {series.color, 1.75, {6, 4}});
}

std::string Subtitle(const MatrixDescription& description) {
  std::string method = MethodText(description);
  switch (description.symmetrization) {
    case Symmetrization::kMean:
      return method + "; mean of both directions";
    case Symmetrization::kMax:
      return method + "; larger of both directions";
    case Symmetrization::kDirected:
      return method + "; both directions of each pair";
  }
  return method;
}

std::string LegendText(const Series& series, const MatrixDescription& description) {
  if (series.values.empty()) return series.name + ": none";
  const std::string median = ReadableDecimal(MedianOfSorted(series.values), 3);
  return series.name + ": " + PairWord(std::ssize(series.values), description) + ", median " +
         WithUnit(median, description) + " (dashed)";
}

void DrawTexts(const Plot& plot,
               const MatrixDescription& description,
               const std::string& title,
               Canvas& canvas) {
  canvas.Text(kTitleAt, title, kTitleStyle, Anchor::kStart);
  canvas.Text(kSubtitleAt, Subtitle(description), kSubtitleStyle, Anchor::kStart);
  double y = kTitlesEnd;
  for (const Series& series : plot.series) {
    const Box swatch = {kLeft, y + 1, 16, 11};
    canvas.FillShape(std::array<Spot, 4>{{{swatch.x, swatch.y},
                                          {swatch.x + swatch.width, swatch.y},
                                          {swatch.x + swatch.width, swatch.y + swatch.height},
                                          {swatch.x, swatch.y + swatch.height}}},
                     series.color, kOpacity);
    canvas.Frame(swatch, {series.color, 1.25});
    canvas.Text({kLeft + 24, y + 6.5}, LegendText(series, description), kAxisStyle, Anchor::kStart);
    y += kLineHeight;
  }
  y = plot.area.y + plot.area.height + kBelow;
  for (const std::string& note : plot.notes) {
    canvas.Text({kPlotMargin, y + 6}, note, kNoteStyle, Anchor::kStart);
    y += kLineHeight;
  }
}

}  // namespace

absl::StatusOr<std::string> HistogramPng(const MatrixView& matrix,
                                         const MatrixDescription& description,
                                         std::span<const std::string> persons) {
  const auto count = std::ssize(matrix.labels);
  const bool fits = matrix.values.rows() == count && matrix.values.cols() == count &&
                    (persons.empty() || std::ssize(persons) == count);
  if (!fits) {
    return absl::InvalidArgumentError("histogram: " + std::to_string(count) + " labels and " +
                                      std::to_string(persons.size()) + " persons for " +
                                      std::to_string(matrix.values.rows()) + " x " +
                                      std::to_string(matrix.values.cols()) + " values");
  }
  const PairValues pairs = CollectPairs(matrix, description.symmetrization, persons);
  const Plot plot = MakePlot(pairs, description);
  COHORT_ASSIGN_OR_RETURN(Canvas canvas, Canvas::Create(kWidth, plot.page_height));
  DrawAxes(plot, description, canvas);
  for (const Series& series : plot.series) DrawSeries(series, plot, canvas);
  for (const Series& series : plot.series) DrawMedian(series, plot, canvas);
  const double bottom = plot.area.y + plot.area.height;
  canvas.Line(std::array<Spot, 2>{{{plot.area.x, bottom}, {plot.area.x + plot.area.width, bottom}}},
              {kInk, 1});
  const std::string title =
      MetricText(description) + " between pairs of " + Counted(count, "mesh", "meshes");
  DrawTexts(plot, description, title, canvas);
  if (pairs.same.empty() && pairs.different.empty()) {
    canvas.Text({plot.area.x + plot.area.width / 2, plot.area.y + plot.area.height / 2},
                "no pair was measured", kAxisStyle, Anchor::kMiddle);
  }
  return canvas.Png();
}

}  // namespace cohort
