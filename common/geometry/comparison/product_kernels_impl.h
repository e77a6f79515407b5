#pragma once

// The loops of product_kernels.h over a vector type, included by one file for each instruction set.
// Everything is a template of a type that is local to that file, so that no code compiled for one
// instruction set can be linked into the path of another.
//
// Simd has: Int, a register of kWidth int16 or half as many int32, which holds zeros when made by
// Zero; Load; MulAdd (adds the products of neighbours, two by two, to int32); AddTo (adds the int32
// to kProductLanes int64); kTileRows: fields whose products with kProductTile others have room in
// the registers.

#include <cstdint>
#include <cstring>

#include "common/geometry/comparison/product_kernels.h"

namespace cohort {

/// Rounds floats to whole numbers, ties to even, in a form that every compiler can make vectors of.
/// A template of a type local to the file, as above.
template <typename Local>
struct QuantizeLoops {
  /// Of finite floats the order of magnitudes is that of their bits.
  static uint32_t Largest(const float* values, int64_t rows) {
    int32_t largest[kProductRow] = {};
    for (int64_t row = 0; row < rows; ++row) {
      for (int lane = 0; lane < kProductRow; ++lane) {
        int32_t bits;
        std::memcpy(&bits, values + row * kProductRow + lane, sizeof(bits));
        bits &= 0x7FFFFFFF;
        largest[lane] = largest[lane] < bits ? bits : largest[lane];
      }
    }
    int32_t all = 0;
    for (const int32_t lane : largest) {
      all = all < lane ? lane : all;
    }
    return static_cast<uint32_t>(all);
  }

  /// In this range neighbouring floats are 1 apart: adding rounds, subtracting is exact.
  static void Quantize(const float* values, int64_t rows, float factor, int16_t* result) {
    constexpr float kWhole = 0x1.8p23F;
    for (int64_t row = 0; row < rows; ++row) {
      for (int lane = 0; lane < kProductRow; ++lane) {
        const int64_t i = row * kProductRow + lane;
        const float whole = (values[i] * factor + kWhole) - kWhole;
        result[i] = static_cast<int16_t>(static_cast<int32_t>(whole));
      }
    }
  }
};

template <typename Simd>
struct ProductLoops {
  using Int = typename Simd::Int;
  /// Values that one lane's kStepsInInt32 are made from.
  static constexpr int64_t kBlock = int64_t{kStepsInInt32} * Simd::kWidth;

  /// kTileRows fields a with kProductTile fields b, the values [begin, end), at most kBlock.
  /// Unrolled by hand, or g++ 12 keeps the sums in memory and copies registers around each product.
  static void AddBlock(const int16_t* const* a,
                       const int16_t* const* b,
                       int64_t begin,
                       int64_t end,
                       int64_t* lanes) {
    constexpr int kPairs = Simd::kTileRows * kProductTile;
    Int sums[kPairs];
#pragma GCC unroll 16
    for (Int& sum : sums) {
      sum = Simd::Zero();
    }
#pragma GCC unroll 4
    for (int64_t i = begin; i < end; i += Simd::kWidth) {
      Int right[kProductTile];
#pragma GCC unroll 4
      for (int column = 0; column < kProductTile; ++column) {
        right[column] = Simd::Load(b[column] + i);
      }
#pragma GCC unroll 4
      for (int row = 0; row < Simd::kTileRows; ++row) {
        const Int left = Simd::Load(a[row] + i);
#pragma GCC unroll 4
        for (int column = 0; column < kProductTile; ++column) {
          Int& sum = sums[row * kProductTile + column];
          sum = Simd::MulAdd(sum, left, right[column]);
        }
      }
    }
#pragma GCC unroll 16
    for (int pair = 0; pair < kPairs; ++pair) {
      Simd::AddTo(sums[pair], lanes + int64_t{pair} * kProductLanes);
    }
  }

  static void AddProducts(const int16_t* const* a,
                          const int16_t* const* b,
                          int64_t rows,
                          int64_t* lanes) {
    const int64_t count = rows * kProductRow;
    for (int row = 0; row < kProductTile; row += Simd::kTileRows) {
      int64_t* const row_lanes = lanes + int64_t{row} * kProductTile * kProductLanes;
      for (int64_t first = 0; first < count; first += kBlock) {
        const int64_t last = count - first < kBlock ? count : first + kBlock;
        AddBlock(a + row, b, first, last, row_lanes);
      }
    }
  }
};

}  // namespace cohort
