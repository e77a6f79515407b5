#include "common/report/decimal.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace cohort {
namespace {

std::optional<std::string> NotANumber(double value) {
  if (std::isnan(value)) return "NA";
  if (std::isinf(value)) return value > 0 ? "Inf" : "-Inf";
  return std::nullopt;
}

// Enough for any double in fixed notation: 309 digits, sign, point and 12 decimals.
using Digits = std::array<char, 340>;

}  // namespace

std::string ShortestDecimal(double value) {
  if (const auto text = NotANumber(value)) return *text;
  Digits digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

std::string FixedDecimal(double value, int digits) {
  if (const auto text = NotANumber(value)) return *text;
  Digits buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, std::clamp(digits, 0, 12));
  std::string text(buffer.data(), end.ptr);
  // "-0.00" would say that the value is negative when all that is known is that it rounds to zero.
  const bool only_zeros = text.find_first_not_of("-0.") == std::string::npos;
  return only_zeros && text.front() == '-' ? text.substr(1) : text;
}

std::string ReadableDecimal(double value, int digits) {
  if (const auto text = NotANumber(value)) return *text;
  const int significant = std::clamp(digits, 1, 12);
  if (value == 0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (exponent >= -4 && exponent < 6) {
    return FixedDecimal(value, std::max(0, significant - 1 - exponent));
  }
  Digits buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::scientific, significant - 1);
  return {buffer.data(), end.ptr};
}

}  // namespace cohort
