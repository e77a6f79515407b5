#pragma once

#include <string>

#include "common/report/plots/svg_page.h"
#include "common/report/quantiles.h"

namespace cohort {

/// How the numbers of an axis are written.
enum class AxisNumbers { kPlain, kPercent };  ///< kPercent: values 0..1 as percents.

/// One axis of a plot.
struct SvgAxis {
  std::string title;
  ValueRange range;  ///< low < high.
  int ticks = 6;     ///< At most about this many.
  AxisNumbers numbers = AxisNumbers::kPlain;
};

/// Where the values of a plot lie on its page.
struct SvgArea {
  Box box;
  SvgAxis x;
  SvgAxis y;

  [[nodiscard]] Spot At(double x_value, double y_value) const {
    return {box.x + x.range.Position(x_value) * box.width,
            box.y + (1 - y.range.Position(y_value)) * box.height};
  }
};

/// Grid, ticks with their numbers, and titles.
void DrawAxes(const SvgArea& area, SvgPage& page);

}  // namespace cohort
