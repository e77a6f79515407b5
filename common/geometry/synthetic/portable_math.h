#pragma once

#include "common/base/random.h"

namespace cohort {

/// Elementary functions built from +, -, *, / and square root only, which IEEE 754 rounds the same
/// way everywhere. The C library's differ in the last bit between versions and processors, and one
/// bit is enough to change a triangulation. Accurate to a few units in the last place.
/// Source: ours (range reduction and Taylor polynomials).

/// e^x; 0 below -700, x <= 700.
[[nodiscard]] double PortableExp(double x);
/// e^(-q / 2), 0 above q = 64 (where it is 1e-14): a bump with q = squared distance / variance.
[[nodiscard]] inline double Gaussian(double q) {
  return q < 64.0 ? PortableExp(-0.5 * q) : 0.0;
}
/// Sine and cosine of an angle in radians, |angle| <= 1e5.
[[nodiscard]] double PortableSin(double angle);
[[nodiscard]] double PortableCos(double angle);

/// Standard normal truncated to [-limit, limit], limit > 0, by rejection from the uniform.
[[nodiscard]] double TruncatedNormal(Random& random, double limit);

/// Seed of an independent stream: mixes a seed with two numbers that tell the streams apart.
[[nodiscard]] uint64_t StreamSeed(uint64_t seed, uint64_t a, uint64_t b);

/// 0 below low, 1 above high, cubic between with zero slope at both ends; low < high.
[[nodiscard]] inline double SmoothStep(double low, double high, double x) {
  const double t = x <= low ? 0.0 : x >= high ? 1.0 : (x - low) / (high - low);
  return t * t * (3.0 - 2.0 * t);
}

/// Maximum of two values, rounded off over a width k > 0 (at a = b it is k / 4 above them).
[[nodiscard]] inline double SmoothMax(double a, double b, double k) {
  const double gap = a > b ? a - b : b - a;
  const double overlap = gap < k ? (k - gap) / k : 0.0;
  return (a > b ? a : b) + 0.25 * k * overlap * overlap;
}

}  // namespace cohort
