#pragma once

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace cohort {

/// Sixteen lanes in one AVX-512 register; see packet_kernels.h. Only for the source that is
/// compiled for it.
struct Avx512Simd {
  using F = __m512;
  using I = __m512i;
  using M = __mmask16;
  struct D {
    __m512d low, high;
  };
  static constexpr bool kFused = true;  ///< Has fused multiply-add.
  static constexpr int kTournament = 4;

  static F Set(float value) { return _mm512_set1_ps(value); }
  static F Load(const float* from) { return _mm512_load_ps(from); }
  static void Store(float* to, F value) { _mm512_store_ps(to, value); }
  static F Add(F a, F b) { return _mm512_add_ps(a, b); }
  static F Sub(F a, F b) { return _mm512_sub_ps(a, b); }
  static F Mul(F a, F b) { return _mm512_mul_ps(a, b); }
  static F MulAdd(F a, F b, F c) { return _mm512_fmadd_ps(a, b, c); }
  static F Min(F a, F b) { return _mm512_min_ps(a, b); }
  static F Max(F a, F b) { return _mm512_max_ps(a, b); }
  static F Sqrt(F a) { return _mm512_sqrt_ps(a); }
  static F SquaredNorm(F x, F y, F z) {
    return _mm512_fmadd_ps(x, x, _mm512_fmadd_ps(y, y, _mm512_mul_ps(z, z)));
  }
  static float LeastOf(F a) { return _mm512_reduce_min_ps(a); }
  static float GreatestOf(F a) { return _mm512_reduce_max_ps(a); }
  static M Less(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
  static M LessEqual(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
  static M Equal(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
  static F Select(M mask, F yes, F no) { return _mm512_mask_mov_ps(no, mask, yes); }

  static I SetI(int32_t value) { return _mm512_set1_epi32(value); }
  static I LoadI(const int32_t* from) { return _mm512_load_si512(from); }
  static void StoreI(int32_t* to, I value) { _mm512_store_si512(to, value); }
  static I AddI(I a, I b) { return _mm512_add_epi32(a, b); }
  static M Differ(I a, I b) { return _mm512_cmpneq_epi32_mask(a, b); }
  static I SelectI(M mask, I yes, I no) { return _mm512_mask_mov_epi32(no, mask, yes); }
  /// Coordinate `side` (0, 1, 2) of the points in these slots.
  static F GatherPoints(const float* points, I slots, int side) {
    const I leaf = _mm512_mullo_epi32(_mm512_srli_epi32(slots, 4), SetI(48));
    const I offset = _mm512_add_epi32(leaf, _mm512_and_si512(slots, SetI(15)));
    return _mm512_i32gather_ps(offset, points + ptrdiff_t{16} * side, 4);
  }

  static M And(M a, M b) { return static_cast<M>(a & b); }
  static bool Any(M mask) { return mask != 0; }
  static unsigned Bits(M mask) { return mask; }
  static M FromBits(unsigned bits) { return static_cast<M>(bits); }
  /// Writes base + lane for each lane of the mask, and rubbish after them (16 slots in all).
  static int StoreLanes(uint32_t* to, M mask, uint32_t base) {
    const I lanes = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
    const I values = _mm512_add_epi32(lanes, SetI(static_cast<int32_t>(base)));
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(mask, values));
    return __builtin_popcount(mask);
  }

  static D LoadD(const double* from) { return {_mm512_load_pd(from), _mm512_load_pd(from + 8)}; }
  static void StoreD(double* to, D value) {
    _mm512_store_pd(to, value.low);
    _mm512_store_pd(to + 8, value.high);
  }
  static D SetD(double value) { return {_mm512_set1_pd(value), _mm512_set1_pd(value)}; }
  static D ToDouble(F a) {
    return {_mm512_cvtps_pd(_mm512_castps512_ps256(a)),
            _mm512_cvtps_pd(_mm512_extractf32x8_ps(a, 1))};
  }
  static F ToFloat(D a) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(a.low)),
                              _mm512_cvtpd_ps(a.high), 1);
  }
  static D AddD(D a, D b) { return {_mm512_add_pd(a.low, b.low), _mm512_add_pd(a.high, b.high)}; }
  static D MulD(D a, D b) { return {_mm512_mul_pd(a.low, b.low), _mm512_mul_pd(a.high, b.high)}; }
};

}  // namespace cohort
