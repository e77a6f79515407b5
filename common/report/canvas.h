#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>
#include <cairo.h>

#include "common/geometry/io/write_mesh.h"
#include "common/report/color_map.h"

namespace cohort {

enum class FontWeight { kNormal, kBold };

/// DejaVu Sans.
struct TextStyle {
  double size = 12;  ///< Points.
  FontWeight weight = FontWeight::kNormal;
  Rgb color = kInk;
};

/// Where a text lies relative to its point, in reading direction.
enum class Anchor { kStart, kMiddle, kEnd };

/// Points, x to the right, y down.
struct Spot {
  double x = 0;
  double y = 0;
};
struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

struct LineStyle {
  Rgb color = kInk;
  double width = 1;
  std::vector<double> dashes = {};  ///< Lengths on, off, ...; empty: solid.
};

/// Width of a text in points.
[[nodiscard]] double TextWidth(std::string_view text, const TextStyle& style);

/// A white page that ends as a PNG with two pixels per point (sharp in print and on dense screens).
/// The same calls give the same bytes; no time stamp or text is kept in the file. Not thread-safe;
/// several canvases may be used at once.
class Canvas {
 public:
  static constexpr int kPixelsPerPoint = 2;

  /// @param width, height  points.
  /// @return kInvalidArgument if the page is larger than cairo allows (32767 pixels) or empty.
  [[nodiscard]] static absl::StatusOr<Canvas> Create(double width, double height);

  void Fill(const Box& box, Rgb color);
  /// `opacity` in 0..1.
  void FillShape(std::span<const Spot> corners, Rgb color, double opacity);
  void Frame(const Box& box, const LineStyle& style);
  void Line(std::span<const Spot> spots, const LineStyle& style);

  /// Horizontal text; the point is at half the height of its capitals.
  void Text(Spot at, std::string_view text, const TextStyle& style, Anchor anchor);
  /// The same, read from bottom to top.
  void VerticalText(Spot at, std::string_view text, const TextStyle& style, Anchor anchor);

  /// Cells of one colour each, row by row, `columns` in a row, stretched without smoothing over
  /// `box` (sharp edges if a cell is a whole number of pixels).
  void Cells(const Box& box, int columns, std::span<const Rgb> colors);

  /// @return kInternal with cairo's message if any drawing failed (out of memory).
  [[nodiscard]] absl::StatusOr<std::string> Png();

 private:
  struct DestroySurface {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  };
  struct DestroyContext {
    void operator()(cairo_t* context) const { cairo_destroy(context); }
  };
  using Surface = std::unique_ptr<cairo_surface_t, DestroySurface>;
  using Context = std::unique_ptr<cairo_t, DestroyContext>;

  Canvas(Surface surface, Context context);
  void SetColor(Rgb color, double opacity);
  void ShowText(std::string_view text, const TextStyle& style, Anchor anchor);

  Surface surface_;
  Context context_;
};

}  // namespace cohort
