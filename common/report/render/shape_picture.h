#pragma once

#include <span>
#include <string>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/report/color_map.h"

namespace cohort {

/// Values of a shape's vertices and how they are shown.
struct ShapeValues {
  std::span<const double> values;  ///< n; NaN: none.
  ColorScale scale = {};
  std::string title = {};     ///< Of the legend, e.g. "RMS distance".
  std::string unit = {};      ///< "mm"; empty: none.
  std::string grey = "none";  ///< In the legend, what grey is, if some vertex is.
};

struct ShapePictureOptions {
  double view_width = 220;  ///< Points, of each of the three views.
  int samples = 2;          ///< RenderOptions::samples.
};

/// The shape in plain shades from the left, the front and the right (PNG), all at one scale.
/// @return kInvalidArgument if the shape has no vertex; kInternal if cairo fails.
[[nodiscard]] absl::StatusOr<std::string> ShapeViewsPng(const TriangleMesh& mesh,
                                                        const ShapePictureOptions& options);

/// The same, coloured by values, with a legend that has the unit, and what is grey.
/// @return also kInvalidArgument if there is not one value per vertex.
[[nodiscard]] absl::StatusOr<std::string> ShapeViewsPng(const TriangleMesh& mesh,
                                                        const ShapeValues& values,
                                                        const ShapePictureOptions& options);

}  // namespace cohort
