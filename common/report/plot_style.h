#pragma once

#include "common/report/canvas.h"
#include "common/report/color_map.h"

namespace cohort {

// What the plots have in common; lengths in points.
inline constexpr double kPlotMargin = 20;
inline constexpr double kTickLength = 4;
inline constexpr double kNoteHeight = 17;
inline constexpr Spot kTitleAt = {kPlotMargin, kPlotMargin + 6};
inline constexpr Spot kSubtitleAt = {kPlotMargin, kPlotMargin + 28};
/// Where the plot itself may begin.
inline constexpr double kTitlesEnd = kPlotMargin + 46;

inline constexpr Rgb kSoftInk = {90, 90, 90};
inline constexpr TextStyle kTitleStyle = {16, FontWeight::kBold, kInk};
inline constexpr TextStyle kSubtitleStyle = {11.5, FontWeight::kNormal, kSoftInk};
inline constexpr TextStyle kAxisStyle = {12, FontWeight::kNormal, kInk};
inline constexpr TextStyle kTickStyle = {10.5, FontWeight::kNormal, kInk};
inline constexpr TextStyle kNoteStyle = {10, FontWeight::kNormal, kSoftInk};

}  // namespace cohort
