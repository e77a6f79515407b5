#include "common/report/render/image.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

#include <cairo.h>

namespace cohort {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

cairo_status_t AppendBytes(void* closure, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

absl::Status Failed(cairo_status_t status) {
  return absl::InternalError(std::string("picture: ") + cairo_status_to_string(status));
}

bool IsGrey(const Image& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(), [](const Rgb& pixel) {
    return pixel.red == pixel.green && pixel.red == pixel.blue;
  });
}

// cairo writes a surface that has nothing but opacity as shades of grey.
void FillGrey(const Image& image, unsigned char* bytes, ptrdiff_t stride) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) bytes[y * stride + x] = image.At(x, y).red;
  }
}

void FillColors(const Image& image, unsigned char* bytes, ptrdiff_t stride) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb color = image.At(x, y);
      const uint32_t packed =
          (uint32_t{color.red} << 16U) | (uint32_t{color.green} << 8U) | uint32_t{color.blue};
      std::memcpy(bytes + y * stride + ptrdiff_t{4} * x, &packed, sizeof packed);
    }
  }
}

}  // namespace

absl::StatusOr<std::string> ImagePng(const Image& image) {
  const int64_t count = int64_t{image.width} * image.height;
  if (image.width < 1 || image.height < 1 || count != std::ssize(image.pixels)) {
    return absl::InvalidArgumentError("picture: " + std::to_string(image.pixels.size()) +
                                      " pixels for " + std::to_string(image.width) + " x " +
                                      std::to_string(image.height));
  }
  const bool is_grey = IsGrey(image);
  const Surface surface(cairo_image_surface_create(is_grey ? CAIRO_FORMAT_A8 : CAIRO_FORMAT_RGB24,
                                                   image.width, image.height),
                        &cairo_surface_destroy);
  const cairo_status_t made = cairo_surface_status(surface.get());
  if (made != CAIRO_STATUS_SUCCESS) return Failed(made);
  unsigned char* const bytes = cairo_image_surface_get_data(surface.get());
  const ptrdiff_t stride = cairo_image_surface_get_stride(surface.get());
  cairo_surface_flush(surface.get());
  is_grey ? FillGrey(image, bytes, stride) : FillColors(image, bytes, stride);
  cairo_surface_mark_dirty(surface.get());
  std::string png;
  const cairo_status_t written =
      cairo_surface_write_to_png_stream(surface.get(), AppendBytes, &png);
  if (written != CAIRO_STATUS_SUCCESS) return Failed(written);
  return png;
}

}  // namespace cohort
