#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/io/write_mesh.h"

namespace cohort {

/// A picture of whole pixels.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Rgb> pixels;  ///< width x height, row by row from the top.

  [[nodiscard]] Rgb At(int x, int y) const {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

/// PNG; in shades of grey, a third of the bytes, if no pixel has a colour.
/// @return kInvalidArgument if there is no pixel, or their number is not width x height; kInternal
///         if cairo fails.
[[nodiscard]] absl::StatusOr<std::string> ImagePng(const Image& image);

}  // namespace cohort
