#include <cmath>

#include "common/geometry/comparison/field_kernels_impl.h"

namespace cohort {
namespace {

/// Four floats, in the compiler's own vector types: whatever the processor has.
struct PortableSimd {
  using Float = float __attribute__((vector_size(16)));
  using Double = double __attribute__((vector_size(16)));
  using Bits = uint64_t __attribute__((vector_size(16)));
  using Indices = int32_t __attribute__((vector_size(16)));
  static constexpr int kWidth = 4;

  static Float Load(const float* source) {
    Float result;
    std::memcpy(&result, source, sizeof(result));
    return result;
  }
  static void Store(float* target, Float v) { std::memcpy(target, &v, sizeof(v)); }
  static Float Splat(float x) { return Float{x, x, x, x}; }
  static Double SplatDouble(double x) { return Double{x, x}; }
  static Float Sqrt(Float v) {
    return Float{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
  }
  static Float Min(Float a, Float b) { return a < b ? a : b; }
  static Float Max(Float a, Float b) { return a > b ? a : b; }
  static Float Abs(Float v) { return v < 0 ? -v : v; }
  /// Values of 2^23 and more are whole already, and may not fit an integer.
  static Float Floor(Float v) {
    const Float limit = Splat(0x1p23F);
    const Float fitting = Abs(v) < limit ? v : Float{};
    const Float cut = __builtin_convertvector(__builtin_convertvector(fitting, Indices), Float);
    const Float floor = cut > fitting ? cut - 1.0F : cut;
    return Abs(v) < limit ? floor : v;
  }
  static Double Low(Float v) { return Double{double{v[0]}, double{v[1]}}; }
  static Double High(Float v) { return Double{double{v[2]}, double{v[3]}}; }
  static void StoreIndices(int32_t* target, Float v) {
    const Indices indices = __builtin_convertvector(v, Indices);
    std::memcpy(target, &indices, sizeof(indices));
  }
  /// Few lanes are in the range: a branch that is seldom taken.
  static int64_t Pick(Float v, Float low, Float high, float* target) {
    const Indices inside = (v >= low) & (v < high);
    uint64_t halves[2];
    std::memcpy(halves, &inside, sizeof(inside));
    int64_t count = 0;
    if ((halves[0] | halves[1]) != 0) {
      for (int i = 0; i < kWidth; ++i) {
        target[count] = v[i];
        count -= inside[i];
      }
    }
    return count;
  }
};

}  // namespace

const FieldKernels* PortableFieldKernels() {
  using Loops = FieldLoops<PortableSimd>;
  static constexpr FieldKernels kKernels = {"portable", &Loops::Accumulate, &Loops::Count,
                                            &Loops::Pick};
  return &kKernels;
}

}  // namespace cohort
