#pragma once

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

/// Dark or white, whichever is easier to read on `background`.
/// Source: contrast ratio of WCAG 2.1.
[[nodiscard]] Rgb InkOn(Rgb background);

}  // namespace cohort
