#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "common/report/plot_style.h"
#include "common/report/plot_text.h"
#include "common/report/plots/plots.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr double kLeft = 66;
constexpr double kTop = 14;
constexpr double kBelow = 52;
constexpr double kLegendWidth = 190;
constexpr double kSide = 460;  // Of the longer side of the plot.
constexpr double kShortest = 220;
constexpr double kLegendRow = 17;
constexpr size_t kMostInLegend = 28;  // Beyond that the styles come again.
constexpr double kMargin = 0.05;      // Of the range, around the points.

ValueRange RangeOf(const std::vector<Spot>& points, double Spot::*coordinate) {
  ValueRange range{0, 0};
  for (size_t i = 0; i < points.size(); ++i) {
    const double value = points[i].*coordinate;
    range.low = i == 0 ? value : std::min(range.low, value);
    range.high = i == 0 ? value : std::max(range.high, value);
  }
  return range;
}

// Widened about its middle to `width`.
ValueRange Widened(const ValueRange& range, double width) {
  const double middle = (range.low + range.high) / 2;
  return {middle - width / 2, middle + width / 2};
}

SvgArea LayOut(const ScatterPlot& plot) {
  ValueRange x = RangeOf(plot.points, &Spot::x);
  ValueRange y = RangeOf(plot.points, &Spot::y);
  double widest = std::max(x.high - x.low, y.high - y.low);
  if (widest <= 0) widest = 1;
  // Equal scales: a long side of kSide, and a short one that is not shorter than kShortest.
  const double full = (1 + 2 * kMargin) * widest;
  const auto with_margin = [&](const ValueRange& range) {
    return Widened(
        range, std::max(range.high - range.low + 2 * kMargin * widest, full * kShortest / kSide));
  };
  x = with_margin(x);
  y = with_margin(y);
  const double scale = kSide / full;
  return {{kLeft, kTop, (x.high - x.low) * scale, (y.high - y.low) * scale},
          {.title = plot.x_title, .range = x, .ticks = 7},
          {.title = plot.y_title, .range = y, .ticks = 7}};
}

void DrawLegend(const Groups& groups, Spot at, SvgPage& page) {
  page.Text(at, groups.title, {11, FontWeight::kBold, kInk}, Anchor::kStart);
  const auto width = [](const std::string& text) { return TextWidth(text, kTickStyle); };
  const std::vector<std::string> fitted = FittedLabels(groups.names, kLegendWidth - 34, width);
  const size_t shown = std::min(groups.names.size(), kMostInLegend);
  for (size_t i = 0; i < shown; ++i) {
    at.y += kLegendRow;
    const GroupStyle style = StyleOfGroup(static_cast<int>(i));
    page.Mark({at.x + 6, at.y}, 4.5, style.shape, style.color);
    page.Text({at.x + 18, at.y}, fitted[i], kTickStyle, Anchor::kStart, groups.names[i]);
  }
  if (shown < groups.names.size()) {
    at.y += kLegendRow;
    page.Text(at, absl::StrCat("and ", groups.names.size() - shown, " more (styles repeat)"),
              kNoteStyle, Anchor::kStart);
  }
  if (std::count(groups.group_of.begin(), groups.group_of.end(), -1) > 0) {
    at.y += kLegendRow;
    page.Mark({at.x + 6, at.y}, 4.5, MarkShape::kCircle, StyleOfGroup(-1).color);
    page.Text({at.x + 18, at.y}, "not known", kTickStyle, Anchor::kStart);
  }
}

}  // namespace

std::string ScatterSvg(const ScatterPlot& plot) {
  const SvgArea area = LayOut(plot);
  const bool has_legend = !plot.groups.names.empty();
  const double right = area.box.x + area.box.width + 16;
  const double legend_rows =
      has_legend ? static_cast<double>(std::min(plot.groups.names.size(), kMostInLegend) + 3) : 0;
  SvgPage page(right + (has_legend ? kLegendWidth : 0),
               std::max(area.box.y + area.box.height + kBelow, kTop + legend_rows * kLegendRow),
               plot.description);
  DrawAxes(area, page);
  for (size_t i = 0; i < plot.points.size(); ++i) {
    const int group = has_legend ? plot.groups.group_of[i] : 0;
    const GroupStyle style = StyleOfGroup(group);
    std::string tooltip = plot.labels[i];
    if (has_legend && group >= 0) {
      absl::StrAppend(&tooltip, "\n", plot.groups.title, ": ",
                      plot.groups.names[static_cast<size_t>(group)]);
    }
    page.Mark(area.At(plot.points[i].x, plot.points[i].y), 4.5, style.shape, style.color, tooltip);
  }
  if (has_legend) DrawLegend(plot.groups, {right + 8, kTop + 6}, page);
  return page.Svg();
}

}  // namespace cohort
