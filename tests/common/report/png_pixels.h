#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <cairo.h>

#include "common/geometry/io/write_mesh.h"

namespace cohort::testing {

/// A decoded PNG.
struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<Rgb> colors;

  [[nodiscard]] Rgb At(int x, int y) const {
    return colors.at(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x));
  }
  [[nodiscard]] int64_t Count(Rgb color) const {
    int64_t count = 0;
    for (const Rgb& pixel : colors) count += pixel == color ? 1 : 0;
    return count;
  }
};

/// Empty (0 x 0) if the bytes are no PNG.
inline Pixels DecodePng(std::string_view png) {
  const auto read = [](void* closure, unsigned char* out, unsigned int size) {
    auto* rest = static_cast<std::string_view*>(closure);
    if (rest->size() < size) return CAIRO_STATUS_READ_ERROR;
    std::memcpy(out, rest->data(), size);
    rest->remove_prefix(size);
    return CAIRO_STATUS_SUCCESS;
  };
  std::string_view rest = png;
  cairo_surface_t* surface = cairo_image_surface_create_from_png_stream(read, &rest);
  Pixels pixels;
  if (cairo_surface_status(surface) == CAIRO_STATUS_SUCCESS) {
    pixels.width = cairo_image_surface_get_width(surface);
    pixels.height = cairo_image_surface_get_height(surface);
    const unsigned char* bytes = cairo_image_surface_get_data(surface);
    const int stride = cairo_image_surface_get_stride(surface);
    for (int y = 0; y < pixels.height; ++y) {
      for (int x = 0; x < pixels.width; ++x) {
        uint32_t packed = 0;
        std::memcpy(&packed, bytes + static_cast<ptrdiff_t>(y) * stride + 4L * x, sizeof packed);
        pixels.colors.push_back({static_cast<uint8_t>(packed >> 16U),
                                 static_cast<uint8_t>(packed >> 8U), static_cast<uint8_t>(packed)});
      }
    }
  }
  cairo_surface_destroy(surface);
  return pixels;
}

/// The types of the chunks of a PNG in order, e.g. "IHDR", "IDAT", "IEND".
inline std::vector<std::string> PngChunks(std::string_view png) {
  std::vector<std::string> types;
  size_t place = 8;
  while (place + 12 <= png.size()) {
    uint32_t size = 0;
    for (size_t i = 0; i < 4; ++i) size = (size << 8U) | static_cast<uint8_t>(png[place + i]);
    types.emplace_back(png.substr(place + 4, 4));
    place += 12 + size;
  }
  return types;
}

}  // namespace cohort::testing
