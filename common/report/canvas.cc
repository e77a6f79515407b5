#include "common/report/canvas.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <utility>

#include "common/base/utf8.h"
#include "common/report/plot_text.h"

#ifdef __SANITIZE_ADDRESS__
// Fontconfig keeps offsets instead of pointers, so LeakSanitizer takes the fonts in its and cairo's
// caches for lost. Here and not in a test, for any program that draws.
extern "C" const char* __lsan_default_suppressions();   // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libfontconfig";
}
#endif

namespace cohort {
namespace {

constexpr double kMaxPixels = 32767;
// Half the height of DejaVu's capitals, in font sizes.
constexpr double kHalfCapital = 0.365;

// Without hinting a text has the same width at every place and scale, so layouts hold.
void SelectFont(cairo_t* context, const TextStyle& style) {
  const std::unique_ptr<cairo_font_options_t, decltype(&cairo_font_options_destroy)> options(
      cairo_font_options_create(), &cairo_font_options_destroy);
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(context, options.get());
  cairo_select_font_face(
      context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
      style.weight == FontWeight::kBold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context, style.size);
}

double AdvanceOf(cairo_t* context, const std::string& printable) {
  cairo_text_extents_t extents{};
  cairo_text_extents(context, printable.c_str(), &extents);
  return extents.x_advance;
}

cairo_status_t AppendBytes(void* closure, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

absl::Status StatusFrom(cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return absl::OkStatus();
  return absl::InternalError(std::string("drawing failed: ") + cairo_status_to_string(status));
}

uint32_t PackedRgb24(Rgb color) {
  return (uint32_t{color.red} << 16U) | (uint32_t{color.green} << 8U) | uint32_t{color.blue};
}

}  // namespace

double TextWidth(std::string_view text, const TextStyle& style) {
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface(
      cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1), &cairo_surface_destroy);
  const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> context(cairo_create(surface.get()),
                                                                   &cairo_destroy);
  SelectFont(context.get(), style);
  return AdvanceOf(context.get(), PrintableUtf8(text));
}

Canvas::Canvas(Surface surface, Context context)
    : surface_(std::move(surface)), context_(std::move(context)) {}

absl::StatusOr<Canvas> Canvas::Create(double width, double height) {
  const double pixel_width = std::ceil(width * kPixelsPerPoint);
  const double pixel_height = std::ceil(height * kPixelsPerPoint);
  const bool is_drawable = pixel_width >= 1 && pixel_height >= 1 && pixel_width <= kMaxPixels &&
                           pixel_height <= kMaxPixels;
  if (!is_drawable) {
    return absl::InvalidArgumentError("a plot of " + std::to_string(pixel_width) + " x " +
                                      std::to_string(pixel_height) + " pixels cannot be drawn");
  }
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(pixel_width),
                                             static_cast<int>(pixel_height)));
  Context context(cairo_create(surface.get()));
  if (const absl::Status status = StatusFrom(cairo_status(context.get())); !status.ok()) {
    return status;
  }
  cairo_scale(context.get(), kPixelsPerPoint, kPixelsPerPoint);
  Canvas canvas(std::move(surface), std::move(context));
  canvas.Fill({0, 0, width + 1, height + 1}, kWhite);
  return canvas;
}

void Canvas::SetColor(Rgb color, double opacity) {
  cairo_set_source_rgba(context_.get(), color.red / 255.0, color.green / 255.0, color.blue / 255.0,
                        opacity);
}

void Canvas::Fill(const Box& box, Rgb color) {
  SetColor(color, 1);
  cairo_rectangle(context_.get(), box.x, box.y, box.width, box.height);
  cairo_fill(context_.get());
}

void Canvas::FillShape(std::span<const Spot> corners, Rgb color, double opacity) {
  SetColor(color, opacity);
  for (const Spot& corner : corners) cairo_line_to(context_.get(), corner.x, corner.y);
  cairo_close_path(context_.get());
  cairo_fill(context_.get());
}

void Canvas::Frame(const Box& box, const LineStyle& style) {
  const double right = box.x + box.width;
  const double bottom = box.y + box.height;
  Line(
      std::array<Spot, 5>{
          {{box.x, box.y}, {right, box.y}, {right, bottom}, {box.x, bottom}, {box.x, box.y}}},
      style);
}

void Canvas::Line(std::span<const Spot> spots, const LineStyle& style) {
  SetColor(style.color, 1);
  cairo_set_line_width(context_.get(), style.width);
  cairo_set_dash(context_.get(), style.dashes.data(), static_cast<int>(style.dashes.size()), 0);
  cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_SQUARE);
  if (!style.dashes.empty()) cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_BUTT);
  for (const Spot& spot : spots) cairo_line_to(context_.get(), spot.x, spot.y);
  cairo_stroke(context_.get());
}

void Canvas::ShowText(std::string_view text, const TextStyle& style, Anchor anchor) {
  SelectFont(context_.get(), style);
  SetColor(style.color, 1);
  const std::string printable = PrintableUtf8(text);
  const double width = AdvanceOf(context_.get(), printable);
  const double shift = anchor == Anchor::kStart ? 0 : anchor == Anchor::kMiddle ? width / 2 : width;
  cairo_move_to(context_.get(), -shift, kHalfCapital * style.size);
  cairo_show_text(context_.get(), printable.c_str());
  cairo_new_path(context_.get());
}

void Canvas::Text(Spot at, std::string_view text, const TextStyle& style, Anchor anchor) {
  cairo_save(context_.get());
  cairo_translate(context_.get(), at.x, at.y);
  ShowText(text, style, anchor);
  cairo_restore(context_.get());
}

void Canvas::VerticalText(Spot at, std::string_view text, const TextStyle& style, Anchor anchor) {
  cairo_save(context_.get());
  cairo_translate(context_.get(), at.x, at.y);
  cairo_rotate(context_.get(), -std::numbers::pi / 2);
  ShowText(text, style, anchor);
  cairo_restore(context_.get());
}

void Canvas::Cells(const Box& box, int columns, std::span<const Rgb> colors) {
  if (columns < 1 || colors.empty()) return;
  const int rows = static_cast<int>(colors.size()) / columns;
  const Surface image(cairo_image_surface_create(CAIRO_FORMAT_RGB24, columns, rows));
  unsigned char* const pixels = cairo_image_surface_get_data(image.get());
  if (pixels == nullptr) {  // Out of memory: as a source it hands its error to the context.
    cairo_set_source_surface(context_.get(), image.get(), 0, 0);
    return;
  }
  const int stride = cairo_image_surface_get_stride(image.get());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const uint32_t packed =
          PackedRgb24(colors[static_cast<size_t>(row) * static_cast<size_t>(columns) +
                             static_cast<size_t>(column)]);
      std::memcpy(pixels + static_cast<ptrdiff_t>(row) * stride + ptrdiff_t{column} * 4, &packed,
                  sizeof packed);
    }
  }
  cairo_surface_mark_dirty(image.get());
  cairo_save(context_.get());
  cairo_translate(context_.get(), box.x, box.y);
  cairo_scale(context_.get(), box.width / columns, box.height / rows);
  cairo_set_source_surface(context_.get(), image.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(context_.get()), CAIRO_FILTER_NEAREST);
  cairo_rectangle(context_.get(), 0, 0, columns, rows);
  cairo_fill(context_.get());
  cairo_restore(context_.get());
}

absl::StatusOr<std::string> Canvas::Png() {
  if (const absl::Status status = StatusFrom(cairo_status(context_.get())); !status.ok()) {
    return status;
  }
  cairo_surface_flush(surface_.get());
  std::string png;
  const cairo_status_t status =
      cairo_surface_write_to_png_stream(surface_.get(), AppendBytes, &png);
  if (status != CAIRO_STATUS_SUCCESS) return StatusFrom(status);
  return png;
}

}  // namespace cohort
