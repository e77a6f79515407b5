#pragma once

#include <cmath>
#include <cstdint>

namespace cohort {

/// Seeded generator with the same numbers on every platform and compiler. Not thread-safe.
/// Source: SplitMix64 (Steele, Lea, Flood 2014); normals by Marsaglia's polar method.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  [[nodiscard]] uint64_t NextBits() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1).
  [[nodiscard]] double Uniform() { return static_cast<double>(NextBits() >> 11) * 0x1.0p-53; }
  /// Uniform in [low, high).
  [[nodiscard]] double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Uniform integer in [0, bound), bound > 0; the bias is below bound / 2^64.
  [[nodiscard]] int64_t Below(int64_t bound) {
    return static_cast<int64_t>(NextBits() % static_cast<uint64_t>(bound));
  }
  /// Standard normal.
  [[nodiscard]] double Normal() {
    double u = 0;
    double v = 0;
    double squared_radius = 0;
    do {
      u = Uniform(-1, 1);
      v = Uniform(-1, 1);
      squared_radius = u * u + v * v;
    } while (squared_radius >= 1 || squared_radius == 0);
    return u * std::sqrt(-2 * std::log(squared_radius) / squared_radius);
  }

 private:
  uint64_t state_;
};

}  // namespace cohort
