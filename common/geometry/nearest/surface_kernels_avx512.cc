// g++ 12 takes the undefined operands inside its own intrinsics for a mistake.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include "common/geometry/nearest/simd_avx512.h"
#include "common/geometry/nearest/surface_kernels_find.h"

namespace cohort {
namespace {

/// One register.
struct Avx512Registers {
  using F = __m512;
  using D = __m512d;
  using MaskD = __mmask8;
  static constexpr int kFloats = 16;
  static constexpr int kDoubles = 8;

  static F Set(float value) { return _mm512_set1_ps(value); }
  static F Load(const float* from) { return _mm512_load_ps(from); }
  static void Store(float* to, F value) { _mm512_store_ps(to, value); }
  static F Sub(F a, F b) { return _mm512_sub_ps(a, b); }
  static F Mul(F a, F b) { return _mm512_mul_ps(a, b); }
  static F MulAdd(F a, F b, F c) { return _mm512_fmadd_ps(a, b, c); }
  static F NegMulAdd(F a, F b, F c) { return _mm512_fnmadd_ps(a, b, c); }
  static F Min(F a, F b) { return _mm512_min_ps(a, b); }
  static F Max(F a, F b) { return _mm512_max_ps(a, b); }
  static F ZeroWherePositive(F test, F value) {
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(test, _mm512_setzero_ps(), _CMP_LE_OQ), value);
  }

  static D SetD(double value) { return _mm512_set1_pd(value); }
  static D LoadFloats(const float* from) { return _mm512_cvtps_pd(_mm256_load_ps(from)); }
  static void StoreD(double* to, D value) { _mm512_store_pd(to, value); }
  static void StoreRounded(float* to, D value) { _mm256_store_ps(to, _mm512_cvtpd_ps(value)); }
  static D AddD(D a, D b) { return _mm512_add_pd(a, b); }
  static D SubD(D a, D b) { return _mm512_sub_pd(a, b); }
  static D MulD(D a, D b) { return _mm512_mul_pd(a, b); }
  static D DivD(D a, D b) { return _mm512_div_pd(a, b); }
  static D MinD(D a, D b) { return _mm512_min_pd(a, b); }
  static D MaxD(D a, D b) { return _mm512_max_pd(a, b); }
  static MaskD LessD(D a, D b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  static D SelectD(MaskD mask, D yes, D no) { return _mm512_mask_mov_pd(no, mask, yes); }
};

}  // namespace

const SurfaceKernels& Avx512SurfaceKernels() {
  static constexpr SurfaceKernels kKernels = {.find = FindOnSurface<Avx512Simd, Avx512Registers>};
  return kKernels;
}

}  // namespace cohort
