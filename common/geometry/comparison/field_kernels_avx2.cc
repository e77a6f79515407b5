#include "common/geometry/comparison/field_kernels_impl.h"

#ifdef __AVX2__
#include <immintrin.h>

namespace cohort {
namespace {

struct Avx2Simd {
  using Float = __m256;
  using Double = __m256d;
  using Bits = uint64_t __attribute__((vector_size(32)));
  static constexpr int kWidth = 8;

  static Float Load(const float* source) { return _mm256_loadu_ps(source); }
  static void Store(float* target, Float v) { _mm256_storeu_ps(target, v); }
  static Float Splat(float x) { return _mm256_set1_ps(x); }
  static Double SplatDouble(double x) { return _mm256_set1_pd(x); }
  static Float Sqrt(Float v) { return _mm256_sqrt_ps(v); }
  static Float Min(Float a, Float b) { return _mm256_min_ps(a, b); }
  static Float Max(Float a, Float b) { return _mm256_max_ps(a, b); }
  static Float Abs(Float v) { return _mm256_andnot_ps(Splat(-0.0F), v); }
  static Float Floor(Float v) { return _mm256_floor_ps(v); }
  static Double Low(Float v) { return _mm256_cvtps_pd(_mm256_castps256_ps128(v)); }
  static Double High(Float v) { return _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1)); }
  static void StoreIndices(int32_t* target, Float v) {
    const __m256i indices = _mm256_cvttps_epi32(v);
    std::memcpy(target, &indices, sizeof(indices));
  }
  /// Few lanes are in the range: a branch that is seldom taken.
  static int64_t Pick(Float v, Float low, Float high, float* target) {
    const Float inside =
        _mm256_and_ps(_mm256_cmp_ps(v, low, _CMP_GE_OQ), _mm256_cmp_ps(v, high, _CMP_LT_OQ));
    auto mask = static_cast<uint32_t>(_mm256_movemask_ps(inside));
    int64_t count = 0;
    for (; mask != 0; mask &= mask - 1) {
      target[count++] = v[__builtin_ctz(mask)];
    }
    return count;
  }
};

}  // namespace

const FieldKernels* Avx2FieldKernels() {
  using Loops = FieldLoops<Avx2Simd>;
  static constexpr FieldKernels kKernels = {"avx2", &Loops::Accumulate, &Loops::Count,
                                            &Loops::Pick};
  return &kKernels;
}

}  // namespace cohort
#else
namespace cohort {

const FieldKernels* Avx2FieldKernels() {
  return nullptr;
}

}  // namespace cohort
#endif
