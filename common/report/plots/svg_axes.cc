#include "common/report/plots/svg_axes.h"

#include <array>

#include "common/report/axis_ticks.h"
#include "common/report/plot_style.h"

namespace cohort {
namespace {

constexpr Rgb kGridColor = {225, 225, 225};

std::string TickText(const SvgAxis& axis, const AxisTicks& ticks, double value) {
  if (axis.numbers == AxisNumbers::kPlain) return ticks.Text(value);
  AxisTicks percents{ticks.step * 100, {}};
  for (const double tick : ticks.values) percents.values.push_back(tick * 100);
  return percents.Text(value * 100) + " %";
}

}  // namespace

void DrawAxes(const SvgArea& area, SvgPage& page) {
  const Box& box = area.box;
  const double right = box.x + box.width;
  const double bottom = box.y + box.height;
  const AxisTicks columns = NiceTicks(area.x.range.low, area.x.range.high, area.x.ticks);
  for (const double tick : columns.values) {
    const double x = area.At(tick, 0).x;
    page.Line(std::array<Spot, 2>{{{x, box.y}, {x, bottom}}}, {kGridColor, 0.75});
    page.Text({x, bottom + 14}, TickText(area.x, columns, tick), kTickStyle, Anchor::kMiddle);
  }
  const AxisTicks rows = NiceTicks(area.y.range.low, area.y.range.high, area.y.ticks);
  for (const double tick : rows.values) {
    const double y = area.At(0, tick).y;
    page.Line(std::array<Spot, 2>{{{box.x, y}, {right, y}}}, {kGridColor, 0.75});
    page.Text({box.x - 6, y}, TickText(area.y, rows, tick), kTickStyle, Anchor::kEnd);
  }
  page.Line(std::array<Spot, 3>{{{box.x, box.y}, {box.x, bottom}, {right, bottom}}}, {kSoftInk, 1});
  page.Text({box.x + box.width / 2, bottom + 36}, area.x.title, kAxisStyle, Anchor::kMiddle);
  page.VerticalText({14, box.y + box.height / 2}, area.y.title, kAxisStyle, Anchor::kMiddle);
}

}  // namespace cohort
