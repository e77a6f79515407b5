#include "common/geometry/comparison/product_kernels_impl.h"

#ifdef __AVX2__
#include <immintrin.h>

namespace cohort {
namespace {

struct Avx2Integers {
  using Int = __m256i;
  static constexpr int kWidth = 16;
  static constexpr int kTileRows = 2;

  static Int Zero() { return _mm256_setzero_si256(); }
  static Int Load(const int16_t* source) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(source));
  }
  static Int MulAdd(Int sum, Int a, Int b) {
    return _mm256_add_epi32(sum, _mm256_madd_epi16(a, b));
  }
  static void AddTo(Int sum, int64_t* lanes) {
    auto* const target = reinterpret_cast<__m256i*>(lanes);
    const Int low = _mm256_cvtepi32_epi64(_mm256_castsi256_si128(sum));
    const Int high = _mm256_cvtepi32_epi64(_mm256_extracti128_si256(sum, 1));
    const Int both = _mm256_add_epi64(low, high);
    _mm256_storeu_si256(target, _mm256_add_epi64(_mm256_loadu_si256(target), both));
  }
};

}  // namespace

const ProductKernels* Avx2ProductKernels() {
  using Rounding = QuantizeLoops<Avx2Integers>;
  static constexpr ProductKernels kKernels = {"avx2", &ProductLoops<Avx2Integers>::AddProducts,
                                              &Rounding::Largest, &Rounding::Quantize};
  return &kKernels;
}

}  // namespace cohort
#else
namespace cohort {

const ProductKernels* Avx2ProductKernels() {
  return nullptr;
}

}  // namespace cohort
#endif
