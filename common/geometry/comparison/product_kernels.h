#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cohort {

/// The inner loops of the products between fields of whole numbers, and of how floats become those.
/// Internal to this folder and its tests.
///
/// All sums are of integers and exact: every instruction set gives the same bits, in whatever order
/// and width it adds.
/// Only plain arrays here: the files that are compiled for one instruction set must not instantiate
/// inline functions of others.
///
/// Values come in rows of so many.
inline constexpr int kProductRow = 32;
/// Fields on each side of a tile of products.
inline constexpr int kProductTile = 4;
/// Parts that the sum of a pair is in; kernels use as many as they like, only their total counts.
inline constexpr int kProductLanes = 8;
inline constexpr int64_t kProductTileLanes = int64_t{kProductTile} * kProductTile * kProductLanes;
/// No value is larger, nor smaller than minus this.
inline constexpr int32_t kLargestFactor = 8191;
/// So many sums of two products (what one multiply-add instruction adds to a lane) fit into int32,
/// whatever the values: then they are moved to int64.
inline constexpr int kStepsInInt32 = 16;
static_assert(int64_t{kStepsInInt32} * 2 * kLargestFactor * kLargestFactor <= INT32_MAX);

struct ProductKernels {
  std::string_view name;  ///< "portable", "avx2", "avx512", "avx512vnni"
  /// Adds the products of a_i with b_j, `rows` rows of values, to the kProductLanes parts from
  /// kProductLanes (kProductTile i + j) on, for all i, j < kProductTile.
  void (*add_products)(const int16_t* const* a,
                       const int16_t* const* b,
                       int64_t rows,
                       int64_t* lanes);
  /// Bits of the largest magnitude of `rows` rows; as large as those of infinity or larger if one
  /// is not finite.
  uint32_t (*largest)(const float* values, int64_t rows);
  /// The whole number nearest to each value * factor, of two the even one. The results must be
  /// within +-kLargestFactor.
  void (*quantize)(const float* values, int64_t rows, float factor, int16_t* result);
};

/// Plain C++, for every processor; and those for one instruction set, null where the compiler does
/// not know it.
[[nodiscard]] const ProductKernels* PortableProductKernels();
[[nodiscard]] const ProductKernels* Avx2ProductKernels();
/// Needs AVX-512 F and BW.
[[nodiscard]] const ProductKernels* Avx512ProductKernels();
/// Needs VNNI as well, for twice the speed.
[[nodiscard]] const ProductKernels* Avx512VnniProductKernels();

/// The kernels this processor can run, slowest first; never empty.
[[nodiscard]] std::span<const ProductKernels* const> RunnableProductKernels();
/// The fastest of them, or of those that COHORT_ISA names (read once), if it runs here.
[[nodiscard]] const ProductKernels& BestProductKernels();

}  // namespace cohort
