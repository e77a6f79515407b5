#pragma once

// What the two files for AVX-512 share: registers of 32 int16. `Local` is a type of the including
// file, so that each has its own. Included after product_kernels_impl.h.

// g++ 12 takes the undefined operands inside its own intrinsics for a mistake.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>

#include <cstdint>

namespace cohort {

template <typename Local>
struct Avx512Integers {
  using Int = __m512i;
  static constexpr int kWidth = 32;
  static constexpr int kTileRows = 4;

  static Int Zero() { return _mm512_setzero_si512(); }
  static Int Load(const int16_t* source) { return _mm512_loadu_si512(source); }
  static void AddTo(Int sum, int64_t* lanes) {
    const Int low = _mm512_cvtepi32_epi64(_mm512_castsi512_si256(sum));
    const Int high = _mm512_cvtepi32_epi64(_mm512_extracti64x4_epi64(sum, 1));
    const Int both = _mm512_add_epi64(low, high);
    _mm512_storeu_si512(lanes, _mm512_add_epi64(_mm512_loadu_si512(lanes), both));
  }
};

}  // namespace cohort
