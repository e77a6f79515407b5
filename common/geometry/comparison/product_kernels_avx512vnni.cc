#include "common/geometry/comparison/product_kernels_impl.h"

#ifdef __AVX512VNNI__
#include "common/geometry/comparison/product_kernels_avx512.h"

namespace cohort {
namespace {

struct WithVnni : Avx512Integers<WithVnni> {
  static Int MulAdd(Int sum, Int a, Int b) { return _mm512_dpwssd_epi32(sum, a, b); }
};

}  // namespace

const ProductKernels* Avx512VnniProductKernels() {
  using Rounding = QuantizeLoops<WithVnni>;
  static constexpr ProductKernels kKernels = {"avx512vnni", &ProductLoops<WithVnni>::AddProducts,
                                              &Rounding::Largest, &Rounding::Quantize};
  return &kKernels;
}

}  // namespace cohort
#else
namespace cohort {

const ProductKernels* Avx512VnniProductKernels() {
  return nullptr;
}

}  // namespace cohort
#endif
