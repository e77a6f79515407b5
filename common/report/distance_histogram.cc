#include "common/report/distance_histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/status_macros.h"
#include "common/report/axis_ticks.h"
#include "common/report/canvas.h"
#include "common/report/decimal.h"
#include "common/report/matrix_description.h"
#include "common/report/pair_distribution.h"
#include "common/report/plot_style.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr double kWidth = 720;
constexpr double kPlotHeight = 300;
constexpr double kLeft = 70;
constexpr double kLineHeight = 18;
constexpr double kBelow = 54;

constexpr Rgb kThereColor = {0, 114, 178};  // Okabe and Ito, as histogram.cc.
constexpr Rgb kBackColor = {213, 94, 0};
constexpr Rgb kGridColor = {222, 222, 222};
constexpr double kPercent = 100;

ScratchVector<double> SortedValues(std::span<const float> distances) {
  ScratchVector<double> values;
  for (const float distance : distances) {
    if (!std::isnan(distance)) {
      values.push_back(double{distance});
    }
  }
  std::sort(values.begin(), values.end());
  return values;
}

struct Curve {
  std::string name;
  Rgb color;
  std::span<const double> values;  ///< Ascending.
  std::vector<double> shares;      ///< Percent of the vertices in each bin.
};

struct Plot {
  Bins bins;
  Box area;
  double top = 1;  ///< Percent.

  [[nodiscard]] double X(double value) const {
    return area.x + (value - bins.first) / (bins.count * bins.width) * area.width;
  }
  [[nodiscard]] double Y(double share) const { return area.y + (1 - share / top) * area.height; }
};

void SetShares(const Bins& bins, Curve& curve) {
  const double unit = kPercent / static_cast<double>(std::max<size_t>(curve.values.size(), 1));
  for (const int64_t count : CountInBins(curve.values, bins)) {
    curve.shares.push_back(static_cast<double>(count) * unit);
  }
}

void DrawAxes(const Plot& plot, const std::string& axis_title, Canvas& canvas) {
  const Box& area = plot.area;
  const double bottom = area.y + area.height;
  const AxisTicks shares = NiceTicks(0, plot.top, 6);
  for (const double share : shares.values) {
    const double y = plot.Y(share);
    canvas.Line(std::array<Spot, 2>{{{area.x, y}, {area.x + area.width, y}}}, {kGridColor, 0.75});
    canvas.Text({area.x - 7, y}, shares.Text(share), kTickStyle, Anchor::kEnd);
  }
  const double high = plot.bins.first + plot.bins.count * plot.bins.width;
  const AxisTicks values = NiceTicks(plot.bins.first, high, 11);
  for (const double value : values.values) {
    const double x = plot.X(value);
    canvas.Line(std::array<Spot, 2>{{{x, bottom}, {x, bottom + kTickLength}}}, {kInk, 0.75});
    canvas.Text({x, bottom + 13}, values.Text(value), kTickStyle, Anchor::kMiddle);
  }
  canvas.Line(std::array<Spot, 2>{{{area.x, bottom}, {area.x + area.width, bottom}}}, {kInk, 1});
  canvas.Text({area.x + area.width / 2, bottom + 36}, axis_title, kAxisStyle, Anchor::kMiddle);
  canvas.VerticalText({kPlotMargin, area.y + area.height / 2}, "share of the vertices (%)",
                      kAxisStyle, Anchor::kMiddle);
}

void DrawCurve(const Curve& curve, const Plot& plot, Canvas& canvas) {
  if (curve.values.empty()) {
    return;
  }
  std::vector<Spot> outline = {{plot.X(plot.bins.first), plot.Y(0)}};
  for (size_t i = 0; i < curve.shares.size(); ++i) {
    const double left = plot.bins.first + static_cast<double>(i) * plot.bins.width;
    outline.push_back({plot.X(left), plot.Y(curve.shares[i])});
    outline.push_back({plot.X(left + plot.bins.width), plot.Y(curve.shares[i])});
  }
  outline.push_back({outline.back().x, plot.Y(0)});
  canvas.FillShape(outline, curve.color, 0.3);
  canvas.Line(outline, {curve.color, 1.25});
  const double x = plot.X(MedianOfSorted(curve.values));
  canvas.Line(std::array<Spot, 2>{{{x, plot.area.y - 4}, {x, plot.area.y + plot.area.height}}},
              {curve.color, 1.75, {6, 4}});
}

void DrawLegend(const Curve& curve, double y, Canvas& canvas) {
  canvas.Fill({kLeft, y + 1, 16, 11}, curve.color);
  const std::string text =
      curve.values.empty()
          ? curve.name + ": no distance counts"
          : curve.name + ": " + Counted(std::ssize(curve.values), "vertex", "vertices") +
                ", median " + ReadableDecimal(MedianOfSorted(curve.values), 3) + " (dashed)";
  canvas.Text({kLeft + 24, y + 6.5}, text, kAxisStyle, Anchor::kStart);
}

}  // namespace

absl::StatusOr<std::string> DistanceHistogramPng(const DistanceSeries& there,
                                                 const DistanceSeries& back,
                                                 const std::string& title,
                                                 const std::string& axis_title) {
  PairValues values;
  values.same = SortedValues(there.distances);
  values.different = SortedValues(back.distances);
  Plot plot{.bins = ChooseBins(values), .area = {}, .top = 1};
  std::array<Curve, 2> curves = {
      {{there.name, kThereColor, values.same, {}}, {back.name, kBackColor, values.different, {}}}};
  for (Curve& curve : curves) {
    SetShares(plot.bins, curve);
    for (const double share : curve.shares) {
      plot.top = std::max(plot.top, share * 1.06);
    }
  }
  const double top = kTitlesEnd - kLineHeight + 2 * kLineHeight + 8;
  plot.area = {kLeft, top, kWidth - kLeft - kPlotMargin - 10, kPlotHeight};
  COHORT_ASSIGN_OR_RETURN(Canvas canvas,
                          Canvas::Create(kWidth, top + kPlotHeight + kBelow + kPlotMargin / 2));
  canvas.Text(kTitleAt, title, kTitleStyle, Anchor::kStart);
  double y = kTitlesEnd - kLineHeight;
  for (const Curve& curve : curves) {
    DrawLegend(curve, y, canvas);
    y += kLineHeight;
  }
  DrawAxes(plot, axis_title, canvas);
  for (const Curve& curve : curves) {
    DrawCurve(curve, plot, canvas);
  }
  return canvas.Png();
}

}  // namespace cohort
