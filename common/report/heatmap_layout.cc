#include "common/report/heatmap_layout.h"

#include <algorithm>
#include <cmath>

#include "common/report/decimal.h"
#include "common/report/plot_style.h"
#include "common/report/plot_text.h"

namespace cohort {
namespace {

// Lengths in points; pixels where the name says so.
constexpr int kMaxSidePixels = 1600;
constexpr int kMaxCellPixels = 144;
constexpr double kMinLabelPitch = 7.5;
constexpr double kMaxLabelWidth = 150;
constexpr double kMinBarHeight = 144;
constexpr double kBarWidth = 16;
constexpr double kBarGap = 22;
constexpr double kMarkGap = kTickLength + 6;  // From the end of a mark to the matrix.
constexpr double kAxisTitleHeight = 24;

double WidestMark(const HeatmapLayout& layout) {
  double widest = 0;
  for (const HeatmapMark& mark : layout.marks) {
    widest = std::max(widest, TextWidth(mark.text, layout.mark_style));
  }
  return widest;
}

double MatrixSide(const HeatmapLayout& layout) {
  return layout.cell * layout.picture.side;
}

double BarHeight(const HeatmapLayout& layout) {
  return std::max(MatrixSide(layout), kMinBarHeight);
}

void AddLabelMarks(std::span<const std::string> labels, HeatmapLayout& layout) {
  layout.mark_style = {std::clamp(layout.cell * 0.82, 6.4, 12.0), FontWeight::kNormal, kInk};
  const auto width = [&](const std::string& text) { return TextWidth(text, layout.mark_style); };
  const std::vector<std::string> fitted = FittedLabels(labels, kMaxLabelWidth, width);
  for (size_t i = 0; i < fitted.size(); ++i) {
    layout.marks.push_back({(static_cast<double>(i) + 0.5) * layout.cell, fitted[i]});
  }
  const bool fits = WidestMark(layout) <= layout.cell - 4;
  layout.column_marks = fits ? MarkDirection::kHorizontal : MarkDirection::kVertical;
}

void AddNumberMarks(int64_t count, HeatmapLayout& layout) {
  const auto last = static_cast<double>(count);
  layout.mark_style = kTickStyle;
  for (const double tick : NiceTicks(0, last, 12).values) {
    const double number = std::max(tick, 1.0);  // Meshes are counted from 1.
    layout.marks.push_back({(number - 0.5) / last * MatrixSide(layout), FixedDecimal(number, 0)});
  }
  layout.row_title = layout.column_title = "mesh, counted in the order of the matrix";
}

std::string SymmetrizationText(Symmetrization symmetrization) {
  switch (symmetrization) {
    case Symmetrization::kMean:
      return "mean of both directions";
    case Symmetrization::kMax:
      return "larger of both directions";
    case Symmetrization::kDirected:
      return "directed: row = source, column = target";
  }
  return "";
}

void AddTitles(int64_t count, const MatrixDescription& description, HeatmapLayout& layout) {
  layout.title = description.title.empty() ? MetricText(description) : description.title;
  layout.title += ", " + Counted(count, "mesh", "meshes");
  layout.subtitle = description.subtitle;
  if (layout.subtitle.empty()) {
    layout.subtitle = MethodText(description) + "; " +
                      (description.is_preview ? "over corresponding points"
                                              : SymmetrizationText(description.symmetrization));
  }
  layout.bar_title = ValueUnit(description);
  if (description.symmetrization != Symmetrization::kDirected) return;
  const bool is_numbered = !layout.row_title.empty();
  layout.row_title = is_numbered ? "source " + layout.row_title : "source";
  layout.column_title = is_numbered ? "target " + layout.column_title : "target";
}

void AddBarTicks(HeatmapLayout& layout) {
  const MatrixPicture& picture = layout.picture;
  const int max_count = std::clamp(static_cast<int>(BarHeight(layout) / 45), 3, 12);
  layout.bar_ticks = NiceTicks(picture.range.low, picture.range.high, max_count);
  if (picture.largest == picture.smallest && picture.largest != 0) {
    // One value, so the ends of the bar stand for nothing.
    layout.bar_ticks = {NiceStep(std::abs(picture.largest) / 500), {picture.largest}};
  }
}

void AddNotes(int64_t count, const MatrixDescription& description, HeatmapLayout& layout) {
  const MatrixPicture& picture = layout.picture;
  if (picture.clipped_high) {
    layout.notes.push_back("The colours end at " +
                           WithUnit(ReadableDecimal(picture.range.high, 3), description) +
                           "; the largest value is " +
                           WithUnit(ReadableDecimal(picture.largest, 3), description) + ".");
  }
  if (picture.missing > 0) {
    layout.notes.push_back("Dark grey: not measured (" + Counted(picture.missing, "cell", "cells") +
                           ").");
  }
  if (picture.side < count) {
    const std::string rows = FixedDecimal(static_cast<double>(count) / picture.side, 1);
    layout.notes.push_back("Each pixel is the mean of about " + rows + " x " + rows + " values.");
  }
}

void WidenFor(const std::string& text, const TextStyle& style, HeatmapLayout& layout) {
  layout.width = std::max(layout.width, kPlotMargin + TextWidth(text, style));
}

// Places the parts from the top left to the bottom right, each as large as it needs to be.
void Arrange(HeatmapLayout& layout) {
  const double mark_width = WidestMark(layout);
  const double mark_height =
      layout.column_marks == MarkDirection::kHorizontal ? layout.mark_style.size : mark_width;
  const double title_height = layout.row_title.empty() ? 0 : kAxisTitleHeight;
  // Whole points, so that cells begin on whole pixels.
  const double left = std::ceil(kPlotMargin + title_height + mark_width + kMarkGap);
  const double top = std::ceil(kTitlesEnd + title_height + mark_height + kMarkGap);
  const double side = MatrixSide(layout);
  layout.matrix = {left, top, side, side};
  layout.row_title_at = {kPlotMargin + 6, top + side / 2};
  layout.column_title_at = {left + side / 2, kTitlesEnd + 6};
  layout.bar = {left + side + kBarGap, top, kBarWidth, BarHeight(layout)};

  const double bar_right = layout.bar.x + kBarWidth;
  layout.width = layout.bar.x + TextWidth(layout.bar_title, kAxisStyle);
  for (const double tick : layout.bar_ticks.values) {
    const double tick_width = TextWidth(layout.bar_ticks.Text(tick), kTickStyle);
    layout.width = std::max(layout.width, bar_right + kTickLength + 4 + tick_width);
  }
  WidenFor(layout.title, kTitleStyle, layout);
  WidenFor(layout.subtitle, kSubtitleStyle, layout);
  for (const std::string& note : layout.notes) WidenFor(note, kNoteStyle, layout);
  layout.width = std::ceil(layout.width + kPlotMargin);
  const double notes_height = static_cast<double>(layout.notes.size()) * kNoteHeight;
  layout.height = std::ceil(top + layout.bar.height + notes_height + kPlotMargin);
}

}  // namespace

HeatmapLayout LayOutHeatmap(const MatrixView& matrix, const MatrixDescription& description) {
  const auto count = static_cast<int64_t>(matrix.labels.size());
  HeatmapLayout layout;
  layout.picture = MakeMatrixPicture(matrix.values, kMaxSidePixels);
  const int cell_pixels = std::clamp(kMaxSidePixels / layout.picture.side, 1, kMaxCellPixels);
  layout.cell = static_cast<double>(cell_pixels) / Canvas::kPixelsPerPoint;
  if (layout.cell >= kMinLabelPitch) {
    AddLabelMarks(matrix.labels, layout);
  } else {
    AddNumberMarks(count, layout);
  }
  AddTitles(count, description, layout);
  AddBarTicks(layout);
  AddNotes(count, description, layout);
  Arrange(layout);
  return layout;
}

}  // namespace cohort
