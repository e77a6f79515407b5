#include "common/report/plots/svg_page.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include <absl/strings/str_cat.h>

#include "common/report/decimal.h"
#include "common/report/markup.h"

namespace cohort {
namespace {

// Half the height of capitals, in font sizes; as in Canvas.
constexpr double kHalfCapital = 0.365;

// A place on the page: to a hundredth of a point, without zeros at the end.
std::string Place(double value) {
  std::string text = FixedDecimal(value, 2);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string Hex(Rgb color) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "#";
  for (const uint8_t channel : {color.red, color.green, color.blue}) {
    text += kDigits[channel / 16U];
    text += kDigits[channel % 16U];
  }
  return text;
}

std::string_view AnchorName(Anchor anchor) {
  switch (anchor) {
    case Anchor::kStart:
      return "start";
    case Anchor::kMiddle:
      return "middle";
    case Anchor::kEnd:
      return "end";
  }
  return "start";
}

// The end of an element, with the tooltip in it.
std::string End(std::string_view tag, std::string_view tooltip) {
  if (tooltip.empty()) return "/>\n";
  return absl::StrCat("><title>", EscapeMarkup(tooltip), "</title></", std::string(tag), ">\n");
}

// Corners of a mark of radius 1, y down; areas alike.
std::span<const Spot> CornersOf(MarkShape shape) {
  static constexpr std::array<Spot, 4> kSquare = {
      {{-0.88, -0.88}, {0.88, -0.88}, {0.88, 0.88}, {-0.88, 0.88}}};
  static constexpr std::array<Spot, 3> kTriangle = {{{0, -1.3}, {1.17, 0.8}, {-1.17, 0.8}}};
  static constexpr std::array<Spot, 4> kDiamond = {{{0, -1.3}, {1.3, 0}, {0, 1.3}, {-1.3, 0}}};
  switch (shape) {
    case MarkShape::kCircle:
      return {};
    case MarkShape::kSquare:
      return kSquare;
    case MarkShape::kTriangle:
      return kTriangle;
    case MarkShape::kDiamond:
      return kDiamond;
  }
  return {};
}

}  // namespace

SvgPage::SvgPage(double width, double height, std::string_view description) {
  const std::string w = Place(width);
  const std::string h = Place(height);
  svg_ = absl::StrCat("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", w, "\" height=\"", h,
                      "\" viewBox=\"0 0 ", w, " ", h, "\" role=\"img\" aria-label=\"",
                      EscapeMarkup(description),
                      "\" font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<rect width=\"", w,
                      "\" height=\"", h, "\" fill=\"#ffffff\"/>\n");
}

void SvgPage::Line(std::span<const Spot> spots, const LineStyle& style) {
  std::string points;
  for (const Spot& spot : spots) absl::StrAppend(&points, Place(spot.x), ",", Place(spot.y), " ");
  if (!points.empty()) points.pop_back();
  absl::StrAppend(&svg_, "<polyline points=\"", points, "\" fill=\"none\" stroke=\"",
                  Hex(style.color), "\" stroke-width=\"", Place(style.width), "\"");
  if (!style.dashes.empty()) {
    std::string dashes;
    for (const double dash : style.dashes) absl::StrAppend(&dashes, Place(dash), " ");
    dashes.pop_back();
    absl::StrAppend(&svg_, " stroke-dasharray=\"", dashes, "\"");
  }
  svg_ += "/>\n";
}

void SvgPage::Fill(const Box& box, Rgb color, double opacity, std::string_view tooltip) {
  absl::StrAppend(&svg_, "<rect x=\"", Place(box.x), "\" y=\"", Place(box.y), "\" width=\"",
                  Place(box.width), "\" height=\"", Place(box.height), "\" fill=\"", Hex(color),
                  "\"");
  if (opacity < 1) absl::StrAppend(&svg_, " fill-opacity=\"", Place(opacity), "\"");
  svg_ += End("rect", tooltip);
}

void SvgPage::Mark(Spot at, double radius, MarkShape shape, Rgb color, std::string_view tooltip) {
  const std::string fill = absl::StrCat("\" fill=\"", Hex(color),
                                        "\" fill-opacity=\"0.85\" stroke=\"#ffffff\" "
                                        "stroke-width=\"0.6\"");
  const std::span<const Spot> corners = CornersOf(shape);
  if (corners.empty()) {
    absl::StrAppend(&svg_, "<circle cx=\"", Place(at.x), "\" cy=\"", Place(at.y), "\" r=\"",
                    Place(radius), fill, End("circle", tooltip));
    return;
  }
  std::string points;
  for (const Spot& corner : corners) {
    absl::StrAppend(&points, points.empty() ? "" : " ", Place(at.x + radius * corner.x), ",",
                    Place(at.y + radius * corner.y));
  }
  absl::StrAppend(&svg_, "<polygon points=\"", points, fill, End("polygon", tooltip));
}

void SvgPage::AddText(std::string_view attributes,
                      std::string_view text,
                      const TextStyle& style,
                      Anchor anchor,
                      std::string_view tooltip) {
  absl::StrAppend(&svg_, "<text ", std::string(attributes), " font-size=\"", Place(style.size),
                  "\" fill=\"", Hex(style.color), "\"");
  if (anchor != Anchor::kStart) {
    absl::StrAppend(&svg_, " text-anchor=\"", std::string(AnchorName(anchor)), "\"");
  }
  if (style.weight == FontWeight::kBold) svg_ += " font-weight=\"bold\"";
  absl::StrAppend(&svg_, ">", EscapeMarkup(text));
  if (!tooltip.empty()) absl::StrAppend(&svg_, "<title>", EscapeMarkup(tooltip), "</title>");
  svg_ += "</text>\n";
}

void SvgPage::Text(Spot at,
                   std::string_view text,
                   const TextStyle& style,
                   Anchor anchor,
                   std::string_view tooltip) {
  AddText(
      absl::StrCat("x=\"", Place(at.x), "\" y=\"", Place(at.y + kHalfCapital * style.size), "\""),
      text, style, anchor, tooltip);
}

void SvgPage::VerticalText(Spot at, std::string_view text, const TextStyle& style, Anchor anchor) {
  AddText(absl::StrCat("transform=\"translate(", Place(at.x + kHalfCapital * style.size), " ",
                       Place(at.y), ") rotate(-90)\""),
          text, style, anchor, {});
}

}  // namespace cohort
