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

constexpr std::array<Rgb, 33> kCoolToWarm = {
    {{59, 76, 192},   {68, 90, 204},   {78, 104, 215},  {88, 117, 225},  {98, 130, 234},
     {108, 142, 241}, {119, 154, 247}, {130, 165, 251}, {141, 176, 254}, {152, 185, 255},
     {163, 194, 255}, {174, 201, 253}, {184, 208, 249}, {194, 213, 244}, {204, 217, 238},
     {213, 219, 230}, {221, 221, 221}, {229, 216, 209}, {236, 211, 198}, {241, 204, 185},
     {245, 196, 173}, {247, 187, 160}, {247, 177, 148}, {247, 166, 135}, {244, 154, 123},
     {241, 141, 111}, {236, 127, 99},  {229, 112, 87},  {222, 97, 76},   {213, 80, 66},
     {203, 62, 56},   {192, 40, 47},   {180, 4, 38}}};

uint8_t Blend(uint8_t a, uint8_t b, double share_of_b) {
  return static_cast<uint8_t>(std::lround(a + (b - a) * share_of_b));
}

// The colour at `value`, clamped to 0..1, of a table whose entries are evenly spaced.
Rgb Between(const std::array<Rgb, 33>& table, double value) {
  const double place = std::clamp(value, 0.0, 1.0) * static_cast<double>(table.size() - 1);
  const size_t lower = std::min(static_cast<size_t>(place), table.size() - 2);
  const double share = place - static_cast<double>(lower);
  const Rgb& a = table[lower];
  const Rgb& b = table[lower + 1];
  return {Blend(a.red, b.red, share), Blend(a.green, b.green, share), Blend(a.blue, b.blue, share)};
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
  return std::isnan(value) ? kNoValueColor : Between(kViridis, value);
}

Rgb MapDivergingColor(double value) {
  return std::isnan(value) ? kNoValueColor : Between(kCoolToWarm, (value + 1) / 2);
}

double ColorScale::First() const {
  return map == Map::kSequential ? low : -Last();
}

double ColorScale::Last() const {
  return map == Map::kSequential ? high : std::max(std::abs(low), std::abs(high));
}

Rgb ColorScale::ColorOf(double value) const {
  const bool is_inside = value >= lower_threshold && value <= upper_threshold;
  if (!is_inside) return kNoValueColor;  // NaN too.
  const double width = Last() - First();
  if (map == Map::kSequential) return MapColor(width > 0 ? (value - First()) / width : 0.5);
  return MapDivergingColor(width > 0 ? value / Last() : 0);
}

Rgb InkOn(Rgb background) {
  return Contrast(kWhite, background) > Contrast(kInk, background) ? kWhite : kInk;
}

}  // namespace cohort
