#pragma once

#include <array>
#include <cstdint>

#include "common/geometry/comparison/field_kernels.h"
#include "common/geometry/comparison/field_totals.h"
#include "common/geometry/comparison/metrics.h"

namespace cohort {

inline constexpr int kSketchBins = kFieldBins;

/// A distance field in 2 KB (about 0.5 KB encoded): exact totals and a linear histogram. Answers
/// every metric, also under thresholds, within an error it states (sketch_measure.h).
///
/// The bin width is a power of two, so that edges and bins are exact, and follows the field, so
/// that scans in metres and whole bones work too: the histogram reaches to the smallest power of
/// two above min(max |d|, 8 RMS), at least 2^-100. A field up to 8 mm has bins of 1/64 mm if it is
/// absolute, 1/32 mm if it is signed. What lies beyond (at most 1/64 of the values: Chebyshev's
/// inequality) is in the bins at the ends.
/// Source: reference performance.md 5.
struct DistanceSketch {
  DistanceSign sign = DistanceSign::kAbsolute;
  FieldTotals totals;
  double bin_width = 0;  ///< Mesh units.
  /// bins[k] counts (first + k) width <= d < (first + k + 1) width with first = FirstBin();
  /// bins[0] also what is below, the last one what is above.
  std::array<uint32_t, kSketchBins> bins{};

  /// 0, or -256 for signed distances.
  [[nodiscard]] int FirstBin() const {
    return sign == DistanceSign::kSigned ? -kSketchBins / 2 : 0;
  }

  friend bool operator==(const DistanceSketch&, const DistanceSketch&) = default;
};

/// The bin width of a field; see above. max_absolute, rms >= 0.
[[nodiscard]] double SketchBinWidth(DistanceSign sign, double max_absolute, double rms);

}  // namespace cohort
