#include "common/geometry/synthetic/portable_math.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace cohort {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;
// pi / 2 and ln 2 as a short number (products with small integers are exact) plus the rest.
constexpr double kHalfPiHigh = 0x1.921fb544p+0;
constexpr double kHalfPiLow = kHalfPi - kHalfPiHigh + 6.123233995736766e-17;
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 1.9082149292705877e-10;

/// sum of terms x^k, Horner from the highest coefficient.
template <size_t N>
double Polynomial(const std::array<double, N>& coefficients, double x) {
  double sum = coefficients[N - 1];
  for (size_t k = N - 1; k-- > 0;) {
    sum = sum * x + coefficients[k];
  }
  return sum;
}

/// sin(r) or cos(r) of quarter turn `quarter`, |r| <= pi / 4.
double SineOfQuarter(double r, int64_t quarter) {
  static constexpr std::array<double, 9> kSine = {1.0,
                                                  -1.0 / 6,
                                                  1.0 / 120,
                                                  -1.0 / 5040,
                                                  1.0 / 362880,
                                                  -1.0 / 39916800,
                                                  1.0 / 6227020800,
                                                  -1.0 / 1307674368000,
                                                  1.0 / 355687428096000};
  static constexpr std::array<double, 9> kCosine = {1.0,
                                                    -1.0 / 2,
                                                    1.0 / 24,
                                                    -1.0 / 720,
                                                    1.0 / 40320,
                                                    -1.0 / 3628800,
                                                    1.0 / 479001600,
                                                    -1.0 / 87178291200,
                                                    1.0 / 20922789888000};
  const double r2 = r * r;
  const double value = (quarter & 1) != 0 ? Polynomial(kCosine, r2) : r * Polynomial(kSine, r2);
  return (quarter & 2) != 0 ? -value : value;
}

double SineFrom(double angle, int64_t first_quarter) {
  const double turns = std::floor(angle / kHalfPi + 0.5);
  const double r = (angle - turns * kHalfPiHigh) - turns * kHalfPiLow;
  return SineOfQuarter(r, static_cast<int64_t>(turns) + first_quarter);
}

}  // namespace

double PortableExp(double x) {
  if (x < -700.0) {
    return 0.0;
  }
  static constexpr std::array<double, 14> kTerms = {1.0,
                                                    1.0,
                                                    1.0 / 2,
                                                    1.0 / 6,
                                                    1.0 / 24,
                                                    1.0 / 120,
                                                    1.0 / 720,
                                                    1.0 / 5040,
                                                    1.0 / 40320,
                                                    1.0 / 362880,
                                                    1.0 / 3628800,
                                                    1.0 / 39916800,
                                                    1.0 / 479001600,
                                                    1.0 / 6227020800};
  const double k = std::floor(x * 1.44269504088896340736 + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  return std::ldexp(Polynomial(kTerms, r), static_cast<int>(k));
}

double PortableSin(double angle) {
  return SineFrom(angle, 0);
}

double PortableCos(double angle) {
  return SineFrom(angle, 1);
}

double TruncatedNormal(Random& random, double limit) {
  for (;;) {
    const double x = random.Uniform(-limit, limit);
    if (random.Uniform() < PortableExp(-0.5 * x * x)) {
      return x;
    }
  }
}

uint64_t StreamSeed(uint64_t seed, uint64_t a, uint64_t b) {
  const uint64_t first = Random(seed).NextBits();
  const uint64_t second = Random(first ^ (a * 0xC2B2AE3D27D4EB4Fu)).NextBits();
  return Random(second ^ (b * 0x165667B19E3779F9u)).NextBits();
}

}  // namespace cohort
