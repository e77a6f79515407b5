#include "common/report/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cohort {
namespace {

constexpr std::array<Rgb, 33> kViridis = {
    {{68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 54, 129},
     {66, 64, 134},  {63, 73, 137},  {59, 82, 139},  {55, 90, 141},  {51, 99, 141},  {47, 106, 142},
     {44, 114, 142}, {41, 122, 142}, {38, 129, 142}, {35, 137, 142}, {33, 144, 140}, {31, 152, 139},
     {31, 159, 136}, {33, 166, 133}, {40, 174, 128}, {49, 181, 123}, {62, 188, 116}, {76, 194, 108},
     {93, 201, 99},  {110, 206, 88}, {130, 211, 76}, {150, 216, 63}, {171, 220, 50}, {192, 223, 36},
     {213, 226, 26}, {234, 229, 26}, {253, 231, 37}}};

uint8_t Blend(uint8_t a, uint8_t b, double share_of_b) {
  return static_cast<uint8_t>(std::lround(a + (b - a) * share_of_b));
}

// Relative luminance, 0..1.
double Luminance(Rgb color) {
  const auto linear = [](uint8_t channel) {
    const double value = channel / 255.0;
    return value <= 0.03928 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.red) + 0.7152 * linear(color.green) + 0.0722 * linear(color.blue);
}

double Contrast(Rgb a, Rgb b) {
  const auto [darker, lighter] = std::minmax({Luminance(a), Luminance(b)});
  return (lighter + 0.05) / (darker + 0.05);
}

}  // namespace

Rgb MapColor(double value) {
  if (std::isnan(value)) return kNoValueColor;
  const double place = std::clamp(value, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const size_t lower = std::min(static_cast<size_t>(place), kViridis.size() - 2);
  const double share = place - static_cast<double>(lower);
  const Rgb& a = kViridis[lower];
  const Rgb& b = kViridis[lower + 1];
  return {Blend(a.red, b.red, share), Blend(a.green, b.green, share), Blend(a.blue, b.blue, share)};
}

Rgb InkOn(Rgb background) {
  return Contrast(kWhite, background) > Contrast(kInk, background) ? kWhite : kInk;
}

}  // namespace cohort
