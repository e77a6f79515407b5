#include "common/report/heatmap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/status_macros.h"
#include "common/report/canvas.h"
#include "common/report/color_map.h"
#include "common/report/decimal.h"
#include "common/report/heatmap_layout.h"
#include "common/report/plot_style.h"

namespace cohort {
namespace {

constexpr int kShades = 256;
constexpr Rgb kDiagonalColor = {232, 232, 232};

Rgb CellColor(const MatrixPicture& picture, int row, int column) {
  if (row == column && picture.shows_diagonal) return kDiagonalColor;
  return MapColor(picture.range.Position(picture.At(row, column)));
}

void DrawCells(const HeatmapLayout& layout, Canvas& canvas) {
  const int side = layout.picture.side;
  std::vector<Rgb> colors;
  colors.reserve(static_cast<size_t>(side) * static_cast<size_t>(side));
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      colors.push_back(CellColor(layout.picture, row, column));
    }
  }
  canvas.Cells(layout.matrix, side, colors);
}

// Values in the squares, if all of them fit.
void DrawValues(const HeatmapLayout& layout, Canvas& canvas) {
  const MatrixPicture& picture = layout.picture;
  const TextStyle style = {std::clamp(layout.cell * 0.28, 9.0, 13.0), FontWeight::kNormal, kInk};
  const double largest = std::max(std::abs(picture.smallest), std::abs(picture.largest));
  const int exponent = largest > 0 ? static_cast<int>(std::floor(std::log10(largest))) : 0;
  if (exponent > 5 || exponent < -4) return;
  const int decimals = std::clamp(2 - exponent, 0, 6);
  if (TextWidth(FixedDecimal(largest, decimals), style) > layout.cell - 6) return;
  for (int row = 0; row < picture.side; ++row) {
    for (int column = 0; column < picture.side; ++column) {
      const double value = picture.At(row, column);
      if (std::isnan(value) || row == column) continue;
      TextStyle contrasting = style;
      contrasting.color = InkOn(CellColor(picture, row, column));
      canvas.Text({layout.matrix.x + (column + 0.5) * layout.cell,
                   layout.matrix.y + (row + 0.5) * layout.cell},
                  FixedDecimal(value, decimals), contrasting, Anchor::kMiddle);
    }
  }
}

void DrawMarks(const HeatmapLayout& layout, Canvas& canvas) {
  const Box& matrix = layout.matrix;
  const double end = kTickLength + 3;
  for (const HeatmapMark& mark : layout.marks) {
    const double x = matrix.x + mark.offset;
    const double y = matrix.y + mark.offset;
    canvas.Line(std::array<Spot, 2>{{{matrix.x - kTickLength, y}, {matrix.x - 1, y}}}, {kInk, 0.5});
    canvas.Line(std::array<Spot, 2>{{{x, matrix.y - kTickLength}, {x, matrix.y - 1}}}, {kInk, 0.5});
    canvas.Text({matrix.x - end, y}, mark.text, layout.mark_style, Anchor::kEnd);
    if (layout.column_marks == MarkDirection::kHorizontal) {
      canvas.Text({x, matrix.y - end - layout.mark_style.size / 2}, mark.text, layout.mark_style,
                  Anchor::kMiddle);
    } else {
      canvas.VerticalText({x, matrix.y - end}, mark.text, layout.mark_style, Anchor::kStart);
    }
  }
}

void DrawTitles(const HeatmapLayout& layout, Canvas& canvas) {
  canvas.Text(kTitleAt, layout.title, kTitleStyle, Anchor::kStart);
  canvas.Text(kSubtitleAt, layout.subtitle, kSubtitleStyle, Anchor::kStart);
  canvas.VerticalText(layout.row_title_at, layout.row_title, kAxisStyle, Anchor::kMiddle);
  canvas.Text(layout.column_title_at, layout.column_title, kAxisStyle, Anchor::kMiddle);
  double y = layout.bar.y + layout.bar.height + kNoteHeight;
  for (const std::string& note : layout.notes) {
    canvas.Text({kPlotMargin, y}, note, kNoteStyle, Anchor::kStart);
    y += kNoteHeight;
  }
}

void DrawBar(const HeatmapLayout& layout, Canvas& canvas) {
  const Box& bar = layout.bar;
  std::vector<Rgb> shades;
  shades.reserve(kShades);
  for (int i = kShades - 1; i >= 0; --i) shades.push_back(MapColor(i / (kShades - 1.0)));
  canvas.Cells(bar, 1, shades);
  canvas.Frame(bar, {kSoftInk, 0.5});
  if (layout.picture.clipped_high) {
    const double middle = bar.x + bar.width / 2;
    canvas.FillShape(
        std::array<Spot, 3>{{{bar.x, bar.y}, {bar.x + bar.width, bar.y}, {middle, bar.y - 8}}},
        shades.front(), 1);
  }
  for (const double tick : layout.bar_ticks.values) {
    const double y = bar.y + (1 - layout.picture.range.Position(tick)) * bar.height;
    const double right = bar.x + bar.width;
    canvas.Line(std::array<Spot, 2>{{{right, y}, {right + kTickLength, y}}}, {kInk, 0.75});
    canvas.Text({right + kTickLength + 4, y}, layout.bar_ticks.Text(tick), kTickStyle,
                Anchor::kStart);
  }
  canvas.Text({bar.x, bar.y - 18}, layout.bar_title, kAxisStyle, Anchor::kStart);
}

}  // namespace

absl::StatusOr<std::string> HeatmapPng(const MatrixView& matrix,
                                       const MatrixDescription& description) {
  const auto count = static_cast<Eigen::Index>(matrix.labels.size());
  if (count < 1 || matrix.values.rows() != count || matrix.values.cols() != count) {
    return absl::InvalidArgumentError("heat map: " + std::to_string(count) + " labels for " +
                                      std::to_string(matrix.values.rows()) + " x " +
                                      std::to_string(matrix.values.cols()) + " values");
  }
  const HeatmapLayout layout = LayOutHeatmap(matrix, description);
  COHORT_ASSIGN_OR_RETURN(Canvas canvas, Canvas::Create(layout.width, layout.height));
  DrawCells(layout, canvas);
  DrawValues(layout, canvas);
  canvas.Frame(layout.matrix, {kSoftInk, 0.5});
  DrawMarks(layout, canvas);
  DrawTitles(layout, canvas);
  DrawBar(layout, canvas);
  return canvas.Png();
}

}  // namespace cohort
