#include "common/report/axis_ticks.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/report/decimal.h"

namespace cohort {
namespace {

// Ten to the n without the last-bit errors of pow, so that steps are the doubles people expect.
double PowerOfTen(int exponent) {
  double power = 1;
  for (int i = 0; i < std::abs(exponent); ++i) power *= 10;
  return exponent < 0 ? 1 / power : power;
}

// Absorbs rounding when a bound is itself a multiple of the step.
constexpr double kSlack = 1e-9;

}  // namespace

double NiceStep(double value) {
  assert(value > 0 && std::isfinite(value));
  const int exponent = static_cast<int>(std::floor(std::log10(value)));
  const double power = PowerOfTen(exponent);
  for (const double mantissa : {1.0, 2.0, 5.0, 10.0}) {
    if (mantissa * power >= value * (1 - kSlack)) return mantissa * power;
  }
  return 10 * power;
}

AxisTicks NiceTicks(double low, double high, int max_count) {
  assert(low < high && max_count >= 2);
  AxisTicks ticks;
  ticks.step = NiceStep((high - low) / (max_count - 1));
  const double first = std::ceil(low / ticks.step - kSlack);
  const double last = std::floor(high / ticks.step + kSlack);
  const int count = static_cast<int>(last - first) + 1;
  for (int i = 0; i < count; ++i) ticks.values.push_back((first + i) * ticks.step);
  return ticks;
}

std::string AxisTicks::Text(double value) const {
  const double largest = values.empty()
                             ? std::abs(value)
                             : std::max(std::abs(values.front()), std::abs(values.back()));
  if (std::abs(value) < step / 2) return "0";
  const int step_exponent = static_cast<int>(std::floor(std::log10(step) + kSlack));
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value)) + kSlack));
  if (largest >= 1e6 || step < 1e-4) {
    return ReadableDecimal(value, std::clamp(exponent - step_exponent + 1, 1, 12));
  }
  return FixedDecimal(value, std::max(0, -step_exponent));
}

}  // namespace cohort
