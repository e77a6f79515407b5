#include <algorithm>

#include "common/report/plot_style.h"
#include "common/report/plots/plots.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr Box kArea = {76, 16, 380, 280};
constexpr double kPageWidth = 480;
constexpr double kBelow = 52;
constexpr double kLegendRow = 17;
constexpr size_t kMostMarks = 30;  // More points than this are a line without marks.

}  // namespace

std::string CurvesSvg(const CurvePlot& plot) {
  const SvgArea area{kArea, plot.x, plot.y};
  const bool has_legend = plot.curves.size() > 1;
  const double legend = has_legend ? kLegendRow * static_cast<double>(plot.curves.size()) : 0;
  const double bottom = kArea.y + kArea.height + kBelow;
  SvgPage page(kPageWidth, bottom + legend, plot.description);
  DrawAxes(area, page);
  double y = bottom + kLegendRow / 2;
  for (const Curve& curve : plot.curves) {
    std::vector<Spot> spots;
    spots.reserve(curve.points.size());
    for (const Spot& point : curve.points) spots.push_back(area.At(point.x, point.y));
    const LineStyle line{curve.style.color, 1.8, curve.dashes};
    page.Line(spots, line);
    const bool has_marks = curve.dashes.empty() && spots.size() <= kMostMarks;
    for (size_t i = 0; has_marks && i < spots.size(); ++i) {
      page.Mark(spots[i], 3.2, curve.style.shape, curve.style.color);
    }
    if (has_legend) {
      page.Line(std::vector<Spot>{{kArea.x, y}, {kArea.x + 24, y}}, line);
      page.Text({kArea.x + 32, y}, curve.name, kTickStyle, Anchor::kStart);
      y += kLegendRow;
    }
  }
  return page.Svg();
}

}  // namespace cohort
