#pragma once

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace cohort {

/// For each mask of 8 lanes the lanes that are set, in order.
struct LanesOfMask {
  alignas(32) int32_t lanes[256][8] = {};
  constexpr LanesOfMask() {
    for (int mask = 0; mask < 256; ++mask) {
      int count = 0;
      for (int lane = 0; lane < 8; ++lane) {
        if ((mask >> lane & 1) != 0) {
          lanes[mask][count++] = lane;
        }
      }
    }
  }
};
inline constexpr LanesOfMask kLanesOfMask;

/// Sixteen lanes in two AVX2 registers; see packet_kernels.h. Only for the source that is compiled
/// for it.
struct Avx2Simd {
  struct F {
    __m256 low, high;
  };
  struct I {
    __m256i low, high;
  };
  using M = F;  ///< All bits of a lane set, or none.
  struct D {
    __m256d part[4];
  };
  static constexpr bool kFused = true;
  static constexpr int kTournament = 2;

  static F Set(float value) { return {_mm256_set1_ps(value), _mm256_set1_ps(value)}; }
  static F Load(const float* from) { return {_mm256_load_ps(from), _mm256_load_ps(from + 8)}; }
  static void Store(float* to, F value) {
    _mm256_store_ps(to, value.low);
    _mm256_store_ps(to + 8, value.high);
  }
  static F Add(F a, F b) { return {_mm256_add_ps(a.low, b.low), _mm256_add_ps(a.high, b.high)}; }
  static F Sub(F a, F b) { return {_mm256_sub_ps(a.low, b.low), _mm256_sub_ps(a.high, b.high)}; }
  static F Mul(F a, F b) { return {_mm256_mul_ps(a.low, b.low), _mm256_mul_ps(a.high, b.high)}; }
  static F MulAdd(F a, F b, F c) {
    return {_mm256_fmadd_ps(a.low, b.low, c.low), _mm256_fmadd_ps(a.high, b.high, c.high)};
  }
  static F Min(F a, F b) { return {_mm256_min_ps(a.low, b.low), _mm256_min_ps(a.high, b.high)}; }
  static F Max(F a, F b) { return {_mm256_max_ps(a.low, b.low), _mm256_max_ps(a.high, b.high)}; }
  static F Sqrt(F a) { return {_mm256_sqrt_ps(a.low), _mm256_sqrt_ps(a.high)}; }
  static F SquaredNorm(F x, F y, F z) {
    return {SquaredNorm8(x.low, y.low, z.low), SquaredNorm8(x.high, y.high, z.high)};
  }
  static float LeastOf(F a) {
    __m256 m = _mm256_min_ps(a.low, a.high);
    __m128 n = _mm_min_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps(m, 1));
    n = _mm_min_ps(n, _mm_movehl_ps(n, n));
    return _mm_cvtss_f32(_mm_min_ss(n, _mm_shuffle_ps(n, n, 1)));
  }
  static float GreatestOf(F a) {
    __m256 m = _mm256_max_ps(a.low, a.high);
    __m128 n = _mm_max_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps(m, 1));
    n = _mm_max_ps(n, _mm_movehl_ps(n, n));
    return _mm_cvtss_f32(_mm_max_ss(n, _mm_shuffle_ps(n, n, 1)));
  }
  static M Less(F a, F b) {
    return {_mm256_cmp_ps(a.low, b.low, _CMP_LT_OQ), _mm256_cmp_ps(a.high, b.high, _CMP_LT_OQ)};
  }
  static M LessEqual(F a, F b) {
    return {_mm256_cmp_ps(a.low, b.low, _CMP_LE_OQ), _mm256_cmp_ps(a.high, b.high, _CMP_LE_OQ)};
  }
  static M Equal(F a, F b) {
    return {_mm256_cmp_ps(a.low, b.low, _CMP_EQ_OQ), _mm256_cmp_ps(a.high, b.high, _CMP_EQ_OQ)};
  }
  static F Select(M mask, F yes, F no) {
    return {_mm256_blendv_ps(no.low, yes.low, mask.low),
            _mm256_blendv_ps(no.high, yes.high, mask.high)};
  }

  static I SetI(int32_t value) { return {_mm256_set1_epi32(value), _mm256_set1_epi32(value)}; }
  static I LoadI(const int32_t* from) {
    return {_mm256_load_si256(reinterpret_cast<const __m256i*>(from)),
            _mm256_load_si256(reinterpret_cast<const __m256i*>(from + 8))};
  }
  static void StoreI(int32_t* to, I value) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(to), value.low);
    _mm256_store_si256(reinterpret_cast<__m256i*>(to + 8), value.high);
  }
  static I AddI(I a, I b) {
    return {_mm256_add_epi32(a.low, b.low), _mm256_add_epi32(a.high, b.high)};
  }
  static M Differ(I a, I b) {
    const __m256i all = _mm256_set1_epi32(-1);
    const __m256i low = _mm256_xor_si256(_mm256_cmpeq_epi32(a.low, b.low), all);
    const __m256i high = _mm256_xor_si256(_mm256_cmpeq_epi32(a.high, b.high), all);
    return {_mm256_castsi256_ps(low), _mm256_castsi256_ps(high)};
  }
  static I SelectI(M mask, I yes, I no) {
    const F chosen = Select(mask, {_mm256_castsi256_ps(yes.low), _mm256_castsi256_ps(yes.high)},
                            {_mm256_castsi256_ps(no.low), _mm256_castsi256_ps(no.high)});
    return {_mm256_castps_si256(chosen.low), _mm256_castps_si256(chosen.high)};
  }
  static F GatherPoints(const float* points, I slots, int side) {
    return {GatherPoints8(points, slots.low, side), GatherPoints8(points, slots.high, side)};
  }

  static M And(M a, M b) { return {_mm256_and_ps(a.low, b.low), _mm256_and_ps(a.high, b.high)}; }
  static bool Any(M mask) { return _mm256_movemask_ps(_mm256_or_ps(mask.low, mask.high)) != 0; }
  static unsigned Bits(M mask) {
    return static_cast<unsigned>(_mm256_movemask_ps(mask.low)) |
           static_cast<unsigned>(_mm256_movemask_ps(mask.high)) << 8U;
  }
  static M FromBits(unsigned bits) {
    const __m256i each = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
    const __m256i low = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits & 255U)), each);
    const __m256i high = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits >> 8U)), each);
    return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(low, each)),
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(high, each))};
  }
  /// Writes base + lane for each lane of the mask, and rubbish after them (16 slots in all).
  static int StoreLanes(uint32_t* to, M mask, uint32_t base) {
    const int count = StoreLanes8(to, mask.low, base);
    return count + StoreLanes8(to + count, mask.high, base + 8);
  }

  static D LoadD(const double* from) {
    return {{_mm256_load_pd(from), _mm256_load_pd(from + 4), _mm256_load_pd(from + 8),
             _mm256_load_pd(from + 12)}};
  }
  static void StoreD(double* to, D value) {
    for (ptrdiff_t i = 0; i < 4; ++i) {
      _mm256_store_pd(to + 4 * i, value.part[i]);
    }
  }
  static D SetD(double value) {
    const __m256d all = _mm256_set1_pd(value);
    return {{all, all, all, all}};
  }
  static D ToDouble(F a) {
    return {{_mm256_cvtps_pd(_mm256_castps256_ps128(a.low)),
             _mm256_cvtps_pd(_mm256_extractf128_ps(a.low, 1)),
             _mm256_cvtps_pd(_mm256_castps256_ps128(a.high)),
             _mm256_cvtps_pd(_mm256_extractf128_ps(a.high, 1))}};
  }
  static F ToFloat(D a) {
    return {_mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(a.part[0])),
                                 _mm256_cvtpd_ps(a.part[1]), 1),
            _mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(a.part[2])),
                                 _mm256_cvtpd_ps(a.part[3]), 1)};
  }
  static D AddD(D a, D b) {
    return {{_mm256_add_pd(a.part[0], b.part[0]), _mm256_add_pd(a.part[1], b.part[1]),
             _mm256_add_pd(a.part[2], b.part[2]), _mm256_add_pd(a.part[3], b.part[3])}};
  }
  static D MulD(D a, D b) {
    return {{_mm256_mul_pd(a.part[0], b.part[0]), _mm256_mul_pd(a.part[1], b.part[1]),
             _mm256_mul_pd(a.part[2], b.part[2]), _mm256_mul_pd(a.part[3], b.part[3])}};
  }

 private:
  static __m256 SquaredNorm8(__m256 x, __m256 y, __m256 z) {
    return _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
  }
  static __m256 GatherPoints8(const float* points, __m256i slots, int side) {
    const __m256i leaf = _mm256_mullo_epi32(_mm256_srli_epi32(slots, 4), _mm256_set1_epi32(48));
    const __m256i lane = _mm256_and_si256(slots, _mm256_set1_epi32(15));
    return _mm256_i32gather_ps(points + ptrdiff_t{16} * side, _mm256_add_epi32(leaf, lane), 4);
  }
  static int StoreLanes8(uint32_t* to, __m256 mask, uint32_t base) {
    const int bits = _mm256_movemask_ps(mask);
    const __m256i lanes =
        _mm256_load_si256(reinterpret_cast<const __m256i*>(kLanesOfMask.lanes[bits]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_add_epi32(lanes, _mm256_set1_epi32(static_cast<int>(base))));
    return __builtin_popcount(static_cast<unsigned>(bits));
  }
};

}  // namespace cohort
