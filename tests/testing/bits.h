#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cohort::testing {

/// The bits of every element, in the order they lie in memory: other than ==, they tell 0 from -0
/// and hold a NaN equal to itself.
template <typename Derived>
[[nodiscard]] std::vector<uint64_t> BitsOf(const Eigen::PlainObjectBase<Derived>& matrix) {
  std::vector<uint64_t> bits(static_cast<size_t>(matrix.size()));
  std::transform(matrix.data(), matrix.data() + matrix.size(), bits.begin(),
                 [](double value) { return std::bit_cast<uint64_t>(value); });
  return bits;
}

}  // namespace cohort::testing
