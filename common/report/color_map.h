#pragma once

#include <limits>

#include "common/geometry/io/write_mesh.h"

namespace cohort {

/// Paper and text.
inline constexpr Rgb kWhite = {255, 255, 255};
inline constexpr Rgb kInk = {34, 34, 34};
/// Colour of "no value" in plots and meshes.
inline constexpr Rgb kNoValueColor = {150, 150, 150};

/// Dark violet (0) over green to yellow (1): perceptually uniform, readable in greyscale print and
/// with colour vision deficiencies. Clamped outside [0, 1]; kNoValueColor for NaN.
/// Source: viridis of van der Walt and Smith 2015 (CC0), 33 of its 256 colours, linear between
/// them; at most 2/255 from the original.
[[nodiscard]] Rgb MapColor(double value);

/// Blue (-1) over light grey (0) to red (1) for values about zero: both arms get darker and
/// stronger at the same, perceptually even rate. Clamped outside [-1, 1]; kNoValueColor for NaN.
/// Source: Moreland 2009, "Diverging Color Maps for Scientific Visualization", cool to warm, 33
/// colours of his formula, linear between them.
[[nodiscard]] Rgb MapDivergingColor(double value);

/// How values of a shape become colours.
struct ColorScale {
  enum class Map { kSequential, kDiverging };
  Map map = Map::kSequential;
  /// What the first and the last colour stand for; beyond them the same colours. With kDiverging
  /// the colours run from -limit to +limit, the larger of the two ends.
  double low = 0;
  double high = 1;
  /// Values outside these are grey, as if there were none.
  double lower_threshold = -std::numeric_limits<double>::infinity();
  double upper_threshold = std::numeric_limits<double>::infinity();

  /// The ends of the colours: low and high, or -limit and +limit.
  [[nodiscard]] double First() const;
  [[nodiscard]] double Last() const;
  [[nodiscard]] Rgb ColorOf(double value) const;
};

/// Dark or white, whichever is easier to read on `background`.
/// Source: contrast ratio of WCAG 2.1.
[[nodiscard]] Rgb InkOn(Rgb background);

}  // namespace cohort
