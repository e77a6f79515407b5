#include "common/geometry/comparison/product_kernels_impl.h"

#ifdef __AVX512BW__
#include "common/geometry/comparison/product_kernels_avx512.h"

namespace cohort {
namespace {

struct WithoutVnni : Avx512Integers<WithoutVnni> {
  static Int MulAdd(Int sum, Int a, Int b) {
    return _mm512_add_epi32(sum, _mm512_madd_epi16(a, b));
  }
};

}  // namespace

const ProductKernels* Avx512ProductKernels() {
  using Rounding = QuantizeLoops<WithoutVnni>;
  static constexpr ProductKernels kKernels = {"avx512", &ProductLoops<WithoutVnni>::AddProducts,
                                              &Rounding::Largest, &Rounding::Quantize};
  return &kKernels;
}

}  // namespace cohort
#else
namespace cohort {

const ProductKernels* Avx512ProductKernels() {
  return nullptr;
}

}  // namespace cohort
#endif
