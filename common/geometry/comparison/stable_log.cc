#include "common/geometry/comparison/stable_log.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace cohort {
namespace {

// ln 2 in two parts: the first has 32 trailing zero bits, so that its product with an exponent is
// exact.
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
constexpr double kHalfRoot = 0x1.6a09e667f3bcdp-1;  ///< sqrt(1/2)

}  // namespace

double StableLog(double x) {
  assert(x >= 0 && x <= std::numeric_limits<double>::max());
  if (x == 0) {
    return -std::numeric_limits<double>::infinity();
  }
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  if (mantissa < kHalfRoot) {
    mantissa *= 2;
    --exponent;
  }
  // ln m = 2 artanh s = 2 (s + s^3 / 3 + s^5 / 5 + ...) with |s| <= 0.172: s^24 < 1e-18.
  const double s = (mantissa - 1) / (mantissa + 1);
  const double square = s * s;
  double series = 0;
  for (int k = 23; k >= 3; k -= 2) {
    series = (series + 1.0 / k) * square;
  }
  return exponent * kLn2High + (2 * s + (2 * s * series + exponent * kLn2Low));
}

double StableExp(double x) {
  if (x < -745.2) {
    return 0;
  }
  if (x > 709.8) {
    return std::numeric_limits<double>::infinity();
  }
  // x = k ln 2 + r with |r| <= 0.35, then Taylor: r^18 / 18! < 1e-24.
  const double k = std::floor(x / (kLn2High + kLn2Low) + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  double series = 1;
  for (int i = 17; i >= 1; --i) {
    series = 1 + series * r / i;
  }
  return std::ldexp(series, static_cast<int>(k));
}

}  // namespace cohort
