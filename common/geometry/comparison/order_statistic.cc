#include "common/geometry/comparison/order_statistic.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

namespace cohort {
namespace {

/// Below this size a partial sort is quicker than a histogram.
constexpr size_t kFewValues = 1024;

/// Unsigned integers in the order of the floats.
uint32_t OrderedBits(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

/// Moves the values whose digit is that of the given rank to the front; the rank becomes the rank
/// among them. Returns how many there are.
size_t KeepBucket(std::span<float> values, int shift, uint32_t digit_mask, int64_t& rank) {
  std::array<int64_t, 4096> counts{};
  for (const float value : values) {
    ++counts.at((OrderedBits(value) >> shift) & digit_mask);
  }
  uint32_t digit = 0;
  while (rank >= counts.at(digit)) {
    rank -= counts.at(digit++);
  }
  size_t kept = 0;
  for (const float value : values) {
    if (((OrderedBits(value) >> shift) & digit_mask) == digit) {
      values[kept++] = value;
    }
  }
  return kept;
}

}  // namespace

int64_t PercentileRank(int64_t count, double q) {
  assert(count >= 1 && q >= 0 && q <= 1);
  const auto rank = static_cast<int64_t>(q * static_cast<double>(count) - 0.5);
  return std::clamp<int64_t>(rank, 0, count - 1);
}

float SelectRank(std::span<float> values, int64_t rank) {
  assert(rank >= 0 && static_cast<size_t>(rank) < values.size());
  struct Digit {
    int shift;
    uint32_t mask;
  };
  for (const Digit digit : {Digit{20, 0xFFF}, Digit{8, 0xFFF}, Digit{0, 0xFF}}) {
    if (values.size() <= kFewValues) {
      break;
    }
    values = values.first(KeepBucket(values, digit.shift, digit.mask, rank));
  }
  const auto nth = values.begin() + rank;
  std::nth_element(values.begin(), nth, values.end());
  return *nth + 0.0F;
}

}  // namespace cohort
