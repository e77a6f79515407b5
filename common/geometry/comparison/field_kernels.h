#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cohort {

/// The inner loops of the metrics: one pass for sums and extremes, one for the histogram, one that
/// picks the values of a bin. Internal to this folder and its tests.
///
/// All sums run in 16 virtual lanes (lane l takes the values i with i mod 16 = l, in index order),
/// in double, without fused multiply-add. Hence every instruction set computes the same bits.
/// Only plain arrays here: the files that are compiled for one instruction set must not instantiate
/// inline functions of others.
inline constexpr int kFieldLanes = 16;
inline constexpr int kFieldBins = 512;
/// Bins are counted in so many parallel tables, so that neighbours do not wait for each other.
inline constexpr int kFieldTables = 4;

/// What the values are: squared distances (rooted on the way), distances, or signed distances.
enum class FieldInput : uint8_t { kSquared, kAbsolute, kSigned };

/// Sums of a field, lane by lane. d = the values, |d| for those that are called absolute.
struct FieldLanes {
  double sum[kFieldLanes];
  double sum_absolute[kFieldLanes];
  double sum_squares[kFieldLanes];
  /// Product of |d| = mantissa 2^exponent, mantissa in [1, 2); meaningless if some d is 0.
  double mantissa[kFieldLanes];
  int64_t exponent[kFieldLanes];
  float min[kFieldLanes];
  float max[kFieldLanes];
  float min_absolute[kFieldLanes];
};

/// Where the bins lie: bin k holds first_bin + k <= d / width < first_bin + k + 1, and the two bins
/// at the ends also what lies beyond. width is a power of two: edges and quotients are exact.
struct FieldBinning {
  float inverse_width;
  int first_bin;  ///< 0, or -kFieldBins / 2 for signed values.
  double mean;
  double deviation[kFieldLanes];  ///< Gets sum (d - mean)^2, lane by lane.
};

struct FieldKernels {
  std::string_view name;  ///< "portable", "avx2", "avx512"
  /// Continues `lanes` with 16 * rows values; writes the distances (roots for kSquared).
  void (*accumulate)(
      FieldInput input, const float* values, int64_t rows, float* distances, FieldLanes& lanes);
  /// Counts 16 * rows distances into kFieldTables tables of kFieldBins counters.
  void (*count)(const float* distances, int64_t rows, FieldBinning& binning, uint32_t* tables);
  /// Copies those of 16 * rows distances with low <= d < high, in order, to `picked`, which has
  /// room for 16 more than there are; returns how many.
  int64_t (*pick)(const float* distances, int64_t rows, float low, float high, float* picked);
};

/// Plain C++, for every processor; and those for one instruction set, null where the compiler does
/// not know it.
[[nodiscard]] const FieldKernels* PortableFieldKernels();
[[nodiscard]] const FieldKernels* Avx2FieldKernels();
[[nodiscard]] const FieldKernels* Avx512FieldKernels();

/// The kernels this processor can run, slowest first; never empty.
[[nodiscard]] std::span<const FieldKernels* const> RunnableFieldKernels();
/// The fastest of them, or the one COHORT_ISA names (read once), if it runs here.
[[nodiscard]] const FieldKernels& BestFieldKernels();

}  // namespace cohort
