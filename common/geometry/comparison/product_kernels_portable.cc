#include "common/geometry/comparison/product_kernels_impl.h"

namespace cohort {
namespace {

/// One field with one other: compilers know this loop, and what the processor has for it.
struct Portable {
  static int64_t Product(const int16_t* a, const int16_t* b, int64_t rows) {
    // In a lane of whatever width: at most kStepsInInt32 times two products, and not more in all.
    constexpr int64_t kBlock = int64_t{2} * kStepsInInt32;
    static_assert(kBlock == kProductRow);
    int64_t total = 0;
    for (int64_t row = 0; row < rows; ++row) {
      int32_t sum = 0;
      for (int64_t i = row * kBlock; i < (row + 1) * kBlock; ++i) {
        sum += int32_t{a[i]} * int32_t{b[i]};
      }
      total += sum;
    }
    return total;
  }

  static void AddProducts(const int16_t* const* a,
                          const int16_t* const* b,
                          int64_t rows,
                          int64_t* lanes) {
    for (int64_t i = 0; i < kProductTile; ++i) {
      for (int64_t j = 0; j < kProductTile; ++j) {
        lanes[(i * kProductTile + j) * kProductLanes] += Product(a[i], b[j], rows);
      }
    }
  }
};

}  // namespace

const ProductKernels* PortableProductKernels() {
  using Rounding = QuantizeLoops<Portable>;
  static constexpr ProductKernels kKernels = {"portable", &Portable::AddProducts,
                                              &Rounding::Largest, &Rounding::Quantize};
  return &kKernels;
}

}  // namespace cohort
