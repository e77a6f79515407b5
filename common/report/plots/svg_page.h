#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/report/canvas.h"

namespace cohort {

/// Shapes of points, told apart without colours.
enum class MarkShape { kCircle, kSquare, kTriangle, kDiamond };

/// A white page that ends as SVG, in a file or inside HTML. Texts are escaped. The same calls give
/// the same bytes. Not thread-safe.
class SvgPage {
 public:
  /// @param width, height  points (of CSS: 1/96 inch on paper).
  /// @param description  what the picture shows, for who cannot see it.
  SvgPage(double width, double height, std::string_view description);

  void Line(std::span<const Spot> spots, const LineStyle& style);
  /// @param tooltip  shown under the pointer; empty: none. As of all below.
  void Fill(const Box& box, Rgb color, double opacity, std::string_view tooltip = {});
  void Mark(Spot at, double radius, MarkShape shape, Rgb color, std::string_view tooltip = {});
  /// Horizontal text; the point is at half the height of its capitals.
  void Text(Spot at,
            std::string_view text,
            const TextStyle& style,
            Anchor anchor,
            std::string_view tooltip = {});
  /// From bottom to top.
  void VerticalText(Spot at, std::string_view text, const TextStyle& style, Anchor anchor);

  /// The page so far, as one element.
  [[nodiscard]] std::string Svg() const { return svg_ + "</svg>\n"; }

 private:
  void AddText(std::string_view attributes,
               std::string_view text,
               const TextStyle& style,
               Anchor anchor,
               std::string_view tooltip);

  std::string svg_;
};

}  // namespace cohort
