#pragma once

#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace cohort {

/// Sixteen lanes in four vectors of what every compiler and processor has; see packet_kernels.h.
/// Without fused multiply-add: SquaredNorm is rounded once more often than the result may be.
struct PortableSimd {
  using F4 = float __attribute__((vector_size(16)));
  using I4 = int32_t __attribute__((vector_size(16)));
  using D2 = double __attribute__((vector_size(16)));
  struct F {
    F4 part[4];
  };
  struct I {
    I4 part[4];
  };
  using M = I;  ///< All bits of a lane set, or none.
  struct D {
    D2 part[8];
  };
  static constexpr bool kFused = false;

  static F Set(float value) {
    const F4 all = {value, value, value, value};
    return {{all, all, all, all}};
  }
  static F Load(const float* from) {
    F result;
    std::memcpy(&result, from, sizeof(result));
    return result;
  }
  static void Store(float* to, F value) { std::memcpy(to, &value, sizeof(value)); }
  static F Add(F a, F b) {
    return {{a.part[0] + b.part[0], a.part[1] + b.part[1], a.part[2] + b.part[2],
             a.part[3] + b.part[3]}};
  }
  static F Sub(F a, F b) {
    return {{a.part[0] - b.part[0], a.part[1] - b.part[1], a.part[2] - b.part[2],
             a.part[3] - b.part[3]}};
  }
  static F Mul(F a, F b) {
    return {{a.part[0] * b.part[0], a.part[1] * b.part[1], a.part[2] * b.part[2],
             a.part[3] * b.part[3]}};
  }
  static F MulAdd(F a, F b, F c) { return Add(Mul(a, b), c); }
  static F4 Min4(F4 a, F4 b) {
#if defined(__SSE2__)
    return _mm_min_ps(a, b);
#else
    return a < b ? a : b;
#endif
  }
  static F4 Max4(F4 a, F4 b) {
#if defined(__SSE2__)
    return _mm_max_ps(a, b);
#else
    return a > b ? a : b;
#endif
  }
  static F Min(F a, F b) {
    return {{Min4(a.part[0], b.part[0]), Min4(a.part[1], b.part[1]), Min4(a.part[2], b.part[2]),
             Min4(a.part[3], b.part[3])}};
  }
  static F Max(F a, F b) {
    return {{Max4(a.part[0], b.part[0]), Max4(a.part[1], b.part[1]), Max4(a.part[2], b.part[2]),
             Max4(a.part[3], b.part[3])}};
  }
  static F Sqrt(F a) {
    float values[16];
    Store(values, a);
    for (float& value : values) {
      value = __builtin_sqrtf(value);
    }
    return Load(values);
  }
  static F4 SquaredNorm4(F4 x, F4 y, F4 z) {
    return x * x + (y * y + z * z);
  }
  static F SquaredNorm(F x, F y, F z) {
    return {{SquaredNorm4(x.part[0], y.part[0], z.part[0]),
             SquaredNorm4(x.part[1], y.part[1], z.part[1]),
             SquaredNorm4(x.part[2], y.part[2], z.part[2]),
             SquaredNorm4(x.part[3], y.part[3], z.part[3])}};
  }
  static float LeastOf(F a) {
    const F4 m = Min4(Min4(a.part[0], a.part[1]), Min4(a.part[2], a.part[3]));
    const float low = m[0] < m[1] ? m[0] : m[1];
    const float high = m[2] < m[3] ? m[2] : m[3];
    return low < high ? low : high;
  }
  static float GreatestOf(F a) {
    const F4 m = Max4(Max4(a.part[0], a.part[1]), Max4(a.part[2], a.part[3]));
    const float low = m[0] > m[1] ? m[0] : m[1];
    const float high = m[2] > m[3] ? m[2] : m[3];
    return low > high ? low : high;
  }
  static M Less(F a, F b) {
    return {{a.part[0] < b.part[0], a.part[1] < b.part[1], a.part[2] < b.part[2],
             a.part[3] < b.part[3]}};
  }
  static M LessEqual(F a, F b) {
    return {{a.part[0] <= b.part[0], a.part[1] <= b.part[1], a.part[2] <= b.part[2],
             a.part[3] <= b.part[3]}};
  }
  static M Equal(F a, F b) {
    return {{a.part[0] == b.part[0], a.part[1] == b.part[1], a.part[2] == b.part[2],
             a.part[3] == b.part[3]}};
  }
  static F Select(M mask, F yes, F no) {
    F result;
    for (int i = 0; i < 4; ++i) {
      result.part[i] = mask.part[i] ? yes.part[i] : no.part[i];
    }
    return result;
  }
  static I SetI(int32_t value) {
    const I4 all = {value, value, value, value};
    return {{all, all, all, all}};
  }
  static I LoadI(const int32_t* from) {
    I result;
    std::memcpy(&result, from, sizeof(result));
    return result;
  }
  static void StoreI(int32_t* to, I value) {
    std::memcpy(to, &value, sizeof(value));
  }
  static M Differ(I a, I b) {
    return {{a.part[0] != b.part[0], a.part[1] != b.part[1], a.part[2] != b.part[2],
             a.part[3] != b.part[3]}};
  }
  static I SelectI(M mask, I yes, I no) {
    I result;
    for (int i = 0; i < 4; ++i) {
      result.part[i] = (mask.part[i] & yes.part[i]) | (~mask.part[i] & no.part[i]);
    }
    return result;
  }
  static F GatherPoints(const float* points, I slots, int side) {
    float values[16];
    int32_t slot[16];
    std::memcpy(slot, &slots, sizeof(slot));
    for (int lane = 0; lane < 16; ++lane) {
      values[lane] = points[(slot[lane] >> 4) * 48 + 16 * side + (slot[lane] & 15)];
    }
    return Load(values);
  }

  static M And(M a, M b) {
    return {{a.part[0] & b.part[0], a.part[1] & b.part[1], a.part[2] & b.part[2],
             a.part[3] & b.part[3]}};
  }
  static bool Any(M mask) {
    return Bits(mask) != 0;
  }
  static unsigned Bits4(I4 mask) {
#if defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
    const I4 each = {1, 2, 4, 8};
    const I4 set = mask & each;
    return static_cast<unsigned>(set[0] | set[1] | set[2] | set[3]);
#endif
  }
  static unsigned Bits(M mask) {
    return Bits4(mask.part[0]) | Bits4(mask.part[1]) << 4U | Bits4(mask.part[2]) << 8U |
           Bits4(mask.part[3]) << 12U;
  }
  static M FromBits(unsigned bits) {
    M mask;
    for (int lane = 0; lane < 16; ++lane) {
      mask.part[lane / 4][lane % 4] = (bits >> static_cast<unsigned>(lane) & 1U) != 0 ? -1 : 0;
    }
    return mask;
  }
  /// Writes base + lane for each lane of the mask, and rubbish after them (16 slots in all).
  static int StoreLanes(uint32_t* to, M mask, uint32_t base) {
    int count = 0;
    for (unsigned bits = Bits(mask); bits != 0; bits &= bits - 1) {
      to[count++] = base + static_cast<uint32_t>(__builtin_ctz(bits));
    }
    return count;
  }

  static D LoadD(const double* from) {
    D result;
    std::memcpy(&result, from, sizeof(result));
    return result;
  }
  static void StoreD(double* to, D value) {
    std::memcpy(to, &value, sizeof(value));
  }
  static D SetD(double value) {
    D result;
    for (D2& part : result.part) {
      part = D2{value, value};
    }
    return result;
  }
  static D ToDouble(F a) {
    D result;
    for (int i = 0; i < 8; ++i) {
      result.part[i] = D2{a.part[i / 2][i % 2 * 2], a.part[i / 2][i % 2 * 2 + 1]};
    }
    return result;
  }
  static F ToFloat(D a) {
    F result;
    for (int i = 0; i < 8; ++i) {
      result.part[i / 2][i % 2 * 2] = static_cast<float>(a.part[i][0]);
      result.part[i / 2][i % 2 * 2 + 1] = static_cast<float>(a.part[i][1]);
    }
    return result;
  }
  static D AddD(D a, D b) {
    for (int i = 0; i < 8; ++i) {
      a.part[i] += b.part[i];
    }
    return a;
  }
  static D MulD(D a, D b) {
    for (int i = 0; i < 8; ++i) {
      a.part[i] *= b.part[i];
    }
    return a;
  }
};

}  // namespace cohort
