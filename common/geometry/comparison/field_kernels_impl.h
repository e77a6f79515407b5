#pragma once

// The loops of field_kernels.h over a vector type, included by one file for each instruction set.
// Everything is a template of a type that is local to that file, so that no code compiled for one
// instruction set can be linked into the path of another.
//
// Simd has: kWidth floats in a Float, which widen to two Double (Low, High), in lane order; Load,
// Store, Sqrt, Floor, Abs, Min and Max (the second operand where neither is smaller or larger),
// Splat, SplatDouble, StoreIndices (truncates to int32), Pick (appends the lanes in a range).
// + - * work on Float and Double, & | >> on Bits.

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "common/geometry/comparison/field_kernels.h"

namespace cohort {

/// Rows that one group of lanes handles before the next group does: stays in the first cache.
inline constexpr int64_t kBlockRows = 64;
/// Factors between two renormalisations: 4 floats are in 2^+-600, the product in 2^+-601.
inline constexpr int64_t kFactors = 4;

template <typename Simd>
struct FieldLoops {
  using Float = typename Simd::Float;
  using Double = typename Simd::Double;
  using Bits = typename Simd::Bits;
  static constexpr int kHalf = Simd::kWidth / 2;

  /// The lanes of one Float: what stays in registers over a block.
  struct Group {
    Double sum[2], sum_absolute[2], sum_squares[2], mantissa[2];
    Bits exponent[2];
    Float min, max, min_absolute;
  };

  template <typename Vector, typename T>
  static void LoadState(Vector& vector, const T* source) {
    static_assert(std::is_trivially_copyable_v<Vector>);
    std::memcpy(&vector, source, sizeof(Vector));
  }
  template <typename Vector, typename T>
  static void StoreState(const Vector& vector, T* target) {
    std::memcpy(target, &vector, sizeof(Vector));
  }

  static Group LoadGroup(const FieldLanes& lanes, int lane) {
    Group group;
    for (int half = 0; half < 2; ++half) {
      const int at = lane + half * kHalf;
      LoadState(group.sum[half], lanes.sum + at);
      LoadState(group.sum_absolute[half], lanes.sum_absolute + at);
      LoadState(group.sum_squares[half], lanes.sum_squares + at);
      LoadState(group.mantissa[half], lanes.mantissa + at);
      LoadState(group.exponent[half], lanes.exponent + at);
    }
    LoadState(group.min, lanes.min + lane);
    LoadState(group.max, lanes.max + lane);
    LoadState(group.min_absolute, lanes.min_absolute + lane);
    return group;
  }

  static void StoreGroup(const Group& group, FieldLanes& lanes, int lane) {
    for (int half = 0; half < 2; ++half) {
      const int at = lane + half * kHalf;
      StoreState(group.sum[half], lanes.sum + at);
      StoreState(group.sum_absolute[half], lanes.sum_absolute + at);
      StoreState(group.sum_squares[half], lanes.sum_squares + at);
      StoreState(group.mantissa[half], lanes.mantissa + at);
      StoreState(group.exponent[half], lanes.exponent + at);
    }
    StoreState(group.min, lanes.min + lane);
    StoreState(group.max, lanes.max + lane);
    StoreState(group.min_absolute, lanes.min_absolute + lane);
  }

  /// Moves the exponent of the product out of it: exact, so that it does not matter when.
  static void Renormalize(Group& group) {
    for (int half = 0; half < 2; ++half) {
      Bits bits;
      std::memcpy(&bits, &group.mantissa[half], sizeof(bits));
      group.exponent[half] += (bits >> 52) - 1023;
      bits = (bits & 0x000FFFFFFFFFFFFFu) | 0x3FF0000000000000u;
      std::memcpy(&group.mantissa[half], &bits, sizeof(bits));
    }
  }

  template <FieldInput kInput>
  static void AddRow(const float* values, float* distances, Group& group) {
    Float d = Simd::Load(values);
    if constexpr (kInput == FieldInput::kSquared) {
      d = Simd::Sqrt(d);
    }
    Simd::Store(distances, d);
    group.min = Simd::Min(d, group.min);
    group.max = Simd::Max(d, group.max);
    const Double wide[2] = {Simd::Low(d), Simd::High(d)};
    for (int half = 0; half < 2; ++half) {
      group.sum[half] = group.sum[half] + wide[half];
      group.sum_squares[half] = group.sum_squares[half] + wide[half] * wide[half];
    }
    if constexpr (kInput == FieldInput::kSigned) {
      const Float a = Simd::Abs(d);
      group.min_absolute = Simd::Min(a, group.min_absolute);
      const Double wide_absolute[2] = {Simd::Low(a), Simd::High(a)};
      for (int half = 0; half < 2; ++half) {
        group.sum_absolute[half] = group.sum_absolute[half] + wide_absolute[half];
        group.mantissa[half] = group.mantissa[half] * wide_absolute[half];
      }
    } else {
      for (int half = 0; half < 2; ++half) {
        group.mantissa[half] = group.mantissa[half] * wide[half];
      }
    }
  }

  template <FieldInput kInput>
  static void AccumulateBlock(const float* values, int64_t rows, float* distances, Group& group) {
    int64_t row = 0;
    for (; row + kFactors <= rows; row += kFactors) {
      for (int64_t k = 0; k < kFactors; ++k) {
        AddRow<kInput>(values + (row + k) * kFieldLanes, distances + (row + k) * kFieldLanes,
                       group);
      }
      Renormalize(group);
    }
    for (; row < rows; ++row) {
      AddRow<kInput>(values + row * kFieldLanes, distances + row * kFieldLanes, group);
    }
    Renormalize(group);
  }

  template <FieldInput kInput>
  static void AccumulateAll(const float* values,
                            int64_t rows,
                            float* distances,
                            FieldLanes& lanes) {
    for (int64_t first = 0; first < rows; first += kBlockRows) {
      const int64_t count = rows - first < kBlockRows ? rows - first : kBlockRows;
      for (int lane = 0; lane < kFieldLanes; lane += Simd::kWidth) {
        Group group = LoadGroup(lanes, lane);
        const int64_t at = first * kFieldLanes + lane;
        AccumulateBlock<kInput>(values + at, count, distances + at, group);
        StoreGroup(group, lanes, lane);
      }
    }
  }

  static void Accumulate(
      FieldInput input, const float* values, int64_t rows, float* distances, FieldLanes& lanes) {
    switch (input) {
      case FieldInput::kSquared:
        return AccumulateAll<FieldInput::kSquared>(values, rows, distances, lanes);
      case FieldInput::kAbsolute:
        return AccumulateAll<FieldInput::kAbsolute>(values, rows, distances, lanes);
      case FieldInput::kSigned:
        return AccumulateAll<FieldInput::kSigned>(values, rows, distances, lanes);
    }
  }

  /// Clamped before it is made an integer: a quotient may exceed every integer type. Absolute
  /// distances need no floor, as StoreIndices cuts.
  template <FieldInput kInput>
  static void IndexBlock(
      const float* distances, int64_t rows, int lane, FieldBinning& binning, int32_t* indices) {
    const Float inverse_width = Simd::Splat(binning.inverse_width);
    const Float first = Simd::Splat(static_cast<float>(binning.first_bin));
    const Float last = Simd::Splat(static_cast<float>(binning.first_bin + kFieldBins - 1));
    const Double mean = Simd::SplatDouble(binning.mean);
    Double low_sum;
    Double high_sum;
    LoadState(low_sum, binning.deviation + lane);
    LoadState(high_sum, binning.deviation + lane + kHalf);
    for (int64_t row = 0; row < rows; ++row) {
      const Float d = Simd::Load(distances + row * kFieldLanes);
      Float bin = d * inverse_width;
      if constexpr (kInput == FieldInput::kSigned) {
        bin = Simd::Floor(bin);
      }
      bin = Simd::Max(Simd::Min(bin, last), first);
      Simd::StoreIndices(indices + row * kFieldLanes, bin - first);
      const Double low = Simd::Low(d) - mean;
      const Double high = Simd::High(d) - mean;
      low_sum = low_sum + low * low;
      high_sum = high_sum + high * high;
    }
    StoreState(low_sum, binning.deviation + lane);
    StoreState(high_sum, binning.deviation + lane + kHalf);
  }

  static void Count(const float* distances, int64_t rows, FieldBinning& binning, uint32_t* tables) {
    alignas(64) int32_t indices[kBlockRows * kFieldLanes];
    for (int64_t first = 0; first < rows; first += kBlockRows) {
      const int64_t count = rows - first < kBlockRows ? rows - first : kBlockRows;
      for (int lane = 0; lane < kFieldLanes; lane += Simd::kWidth) {
        const float* block = distances + first * kFieldLanes + lane;
        if (binning.first_bin < 0) {
          IndexBlock<FieldInput::kSigned>(block, count, lane, binning, indices + lane);
        } else {
          IndexBlock<FieldInput::kAbsolute>(block, count, lane, binning, indices + lane);
        }
      }
      for (int64_t i = 0; i < count * kFieldLanes; i += kFieldTables) {
        ++tables[indices[i]];
        ++tables[kFieldBins + indices[i + 1]];
        ++tables[2 * kFieldBins + indices[i + 2]];
        ++tables[3 * kFieldBins + indices[i + 3]];
      }
    }
  }

  static int64_t Pick(const float* distances, int64_t rows, float low, float high, float* picked) {
    const Float lows = Simd::Splat(low);
    const Float highs = Simd::Splat(high);
    int64_t count = 0;
    for (int64_t i = 0; i < rows * kFieldLanes; i += Simd::kWidth) {
      count += Simd::Pick(Simd::Load(distances + i), lows, highs, picked + count);
    }
    return count;
  }
};

}  // namespace cohort
