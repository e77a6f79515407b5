#include "common/geometry/comparison/field_kernels_impl.h"

#ifdef __AVX512F__
// g++ 12 takes the undefined operands inside its own intrinsics for a mistake.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>

namespace cohort {
namespace {

/// Needs AVX-512 F alone.
struct Avx512Simd {
  using Float = __m512;
  using Double = __m512d;
  using Bits = uint64_t __attribute__((vector_size(64)));
  static constexpr int kWidth = 16;

  static Float Load(const float* source) { return _mm512_loadu_ps(source); }
  static void Store(float* target, Float v) { _mm512_storeu_ps(target, v); }
  static Float Splat(float x) { return _mm512_set1_ps(x); }
  static Double SplatDouble(double x) { return _mm512_set1_pd(x); }
  static Float Sqrt(Float v) { return _mm512_sqrt_ps(v); }
  static Float Min(Float a, Float b) { return _mm512_min_ps(a, b); }
  static Float Max(Float a, Float b) { return _mm512_max_ps(a, b); }
  static Float Abs(Float v) { return _mm512_abs_ps(v); }
  static Float Floor(Float v) { return _mm512_floor_ps(v); }
  static Double Low(Float v) { return _mm512_cvtps_pd(_mm512_castps512_ps256(v)); }
  static Double High(Float v) {
    const __m512d pairs = _mm512_castps_pd(v);
    return _mm512_cvtps_pd(_mm256_castpd_ps(_mm512_extractf64x4_pd(pairs, 1)));
  }
  static void StoreIndices(int32_t* target, Float v) {
    _mm512_storeu_si512(target, _mm512_cvttps_epi32(v));
  }
  static int64_t Pick(Float v, Float low, Float high, float* target) {
    const __mmask16 inside =
        _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(v, low, _CMP_GE_OQ), v, high, _CMP_LT_OQ);
    Store(target, _mm512_maskz_compress_ps(inside, v));
    return __builtin_popcount(inside);
  }
};

}  // namespace

const FieldKernels* Avx512FieldKernels() {
  using Loops = FieldLoops<Avx512Simd>;
  static constexpr FieldKernels kKernels = {"avx512", &Loops::Accumulate, &Loops::Count,
                                            &Loops::Pick};
  return &kKernels;
}

}  // namespace cohort
#else
namespace cohort {

const FieldKernels* Avx512FieldKernels() {
  return nullptr;
}

}  // namespace cohort
#endif
