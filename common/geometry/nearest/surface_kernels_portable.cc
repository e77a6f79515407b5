#include "common/geometry/nearest/simd_portable.h"
#include "common/geometry/nearest/surface_kernels_find.h"

namespace cohort {
namespace {

/// Vectors of 16 bytes.
struct PortableRegisters {
  using F = PortableSimd::F4;
  using D = PortableSimd::D2;
  using MaskD = int64_t __attribute__((vector_size(16)));
  static constexpr int kFloats = 4;
  static constexpr int kDoubles = 2;

  static F Set(float value) { return F{value, value, value, value}; }
  static F Load(const float* from) {
    F result;
    __builtin_memcpy(&result, from, sizeof(result));
    return result;
  }
  static void Store(float* to, F value) { __builtin_memcpy(to, &value, sizeof(value)); }
  static F Sub(F a, F b) { return a - b; }
  static F Mul(F a, F b) { return a * b; }
  static F MulAdd(F a, F b, F c) { return a * b + c; }
  static F NegMulAdd(F a, F b, F c) { return c - a * b; }
  static F Min(F a, F b) { return PortableSimd::Min4(a, b); }
  static F Max(F a, F b) { return PortableSimd::Max4(a, b); }
  static F ZeroWherePositive(F test, F value) { return test > 0.0F ? F{} : value; }

  static D SetD(double value) { return D{value, value}; }
  static D LoadFloats(const float* from) { return D{from[0], from[1]}; }
  static void StoreD(double* to, D value) { __builtin_memcpy(to, &value, sizeof(value)); }
  static void StoreRounded(float* to, D value) {
    to[0] = static_cast<float>(value[0]);
    to[1] = static_cast<float>(value[1]);
  }
  static D AddD(D a, D b) { return a + b; }
  static D SubD(D a, D b) { return a - b; }
  static D MulD(D a, D b) { return a * b; }
  static D DivD(D a, D b) { return a / b; }
  static D MinD(D a, D b) { return a < b ? a : b; }
  static D MaxD(D a, D b) { return a > b ? a : b; }
  static MaskD LessD(D a, D b) { return a < b; }
  static D SelectD(MaskD mask, D yes, D no) { return mask ? yes : no; }
};

}  // namespace

const SurfaceKernels& PortableSurfaceKernels() {
  static constexpr SurfaceKernels kKernels = {.find =
                                                  FindOnSurface<PortableSimd, PortableRegisters>};
  return kKernels;
}

}  // namespace cohort
