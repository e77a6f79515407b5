#pragma once

#include <string>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/report/axis_ticks.h"
#include "common/report/canvas.h"
#include "common/report/matrix_description.h"
#include "common/report/matrix_picture.h"

namespace cohort {

/// How the names of the columns stand above the matrix.
enum class MarkDirection { kHorizontal, kVertical };

/// A mark beside the rows and above the columns.
struct HeatmapMark {
  double offset = 0;  ///< From the matrix's corner to the middle of the row or column.
  std::string text;
};

/// Everything a heat map shows and where it stands; lengths in points.
struct HeatmapLayout {
  MatrixPicture picture;
  double cell = 0;  ///< Side of a cell of the picture.
  Box matrix;
  std::vector<HeatmapMark> marks;
  TextStyle mark_style;
  MarkDirection column_marks = MarkDirection::kHorizontal;
  std::string title;
  std::string subtitle;
  std::string row_title;  ///< Empty: none.
  Spot row_title_at;      ///< Middle of the vertical text.
  std::string column_title;
  Spot column_title_at;
  Box bar;
  AxisTicks bar_ticks;
  std::string bar_title;  ///< The unit.
  std::vector<std::string> notes;
  double width = 0;
  double height = 0;
};

/// @param matrix  N >= 1 labels and N x N values.
[[nodiscard]] HeatmapLayout LayOutHeatmap(const MatrixView& matrix,
                                          const MatrixDescription& description);

}  // namespace cohort
