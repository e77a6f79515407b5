#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace cohort {

/// How long the tasks of one stage took: eight bins to the octave from a millisecond to a month, so
/// that a quantile is right to 9 %. For decisions about time only; no result depends on it.
class DurationHistogram {
 public:
  void Add(double seconds) {
    ++counts_[static_cast<size_t>(BinOf(seconds))];
    ++total_;
  }
  [[nodiscard]] int64_t Count() const { return total_; }
  /// The upper edge of the bin that holds the quantile, in seconds. @param share  0 to 1.
  [[nodiscard]] double Quantile(double share) const {
    const auto rank = static_cast<int64_t>(std::ceil(share * static_cast<double>(total_)));
    int64_t below = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      below += counts_[static_cast<size_t>(bin)];
      if (below >= rank && below > 0) {
        return kLeast * std::exp2((bin + 1) / kBinsPerOctave);
      }
    }
    return 0;
  }

 private:
  static constexpr int kBins = 256;
  static constexpr double kBinsPerOctave = 8;
  static constexpr double kLeast = 1e-3;

  static int BinOf(double seconds) {
    const double bin = kBinsPerOctave * std::log2(std::max(seconds, kLeast) / kLeast);
    return std::min(static_cast<int>(bin), kBins - 1);
  }

  std::array<int64_t, kBins> counts_{};
  int64_t total_ = 0;
};

}  // namespace cohort
