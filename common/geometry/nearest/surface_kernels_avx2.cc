#include "common/geometry/nearest/simd_avx2.h"
#include "common/geometry/nearest/surface_kernels_find.h"

namespace cohort {
namespace {

/// One register.
struct Avx2Registers {
  using F = __m256;
  using D = __m256d;
  using MaskD = __m256d;
  static constexpr int kFloats = 8;
  static constexpr int kDoubles = 4;

  static F Set(float value) { return _mm256_set1_ps(value); }
  static F Load(const float* from) { return _mm256_load_ps(from); }
  static void Store(float* to, F value) { _mm256_store_ps(to, value); }
  static F Sub(F a, F b) { return _mm256_sub_ps(a, b); }
  static F Mul(F a, F b) { return _mm256_mul_ps(a, b); }
  static F MulAdd(F a, F b, F c) { return _mm256_fmadd_ps(a, b, c); }
  static F NegMulAdd(F a, F b, F c) { return _mm256_fnmadd_ps(a, b, c); }
  static F Min(F a, F b) { return _mm256_min_ps(a, b); }
  static F Max(F a, F b) { return _mm256_max_ps(a, b); }
  static F ZeroWherePositive(F test, F value) {
    return _mm256_and_ps(_mm256_cmp_ps(test, _mm256_setzero_ps(), _CMP_LE_OQ), value);
  }

  static D SetD(double value) { return _mm256_set1_pd(value); }
  static D LoadFloats(const float* from) { return _mm256_cvtps_pd(_mm_load_ps(from)); }
  static void StoreD(double* to, D value) { _mm256_store_pd(to, value); }
  static void StoreRounded(float* to, D value) { _mm_store_ps(to, _mm256_cvtpd_ps(value)); }
  static D AddD(D a, D b) { return _mm256_add_pd(a, b); }
  static D SubD(D a, D b) { return _mm256_sub_pd(a, b); }
  static D MulD(D a, D b) { return _mm256_mul_pd(a, b); }
  static D DivD(D a, D b) { return _mm256_div_pd(a, b); }
  static D MinD(D a, D b) { return _mm256_min_pd(a, b); }
  static D MaxD(D a, D b) { return _mm256_max_pd(a, b); }
  static MaskD LessD(D a, D b) { return _mm256_cmp_pd(a, b, _CMP_LT_OQ); }
  static D SelectD(MaskD mask, D yes, D no) { return _mm256_blendv_pd(no, yes, mask); }
};

}  // namespace

const SurfaceKernels& Avx2SurfaceKernels() {
  static constexpr SurfaceKernels kKernels = {.find = FindOnSurface<Avx2Simd, Avx2Registers>};
  return kKernels;
}

}  // namespace cohort
