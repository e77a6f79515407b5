#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "common/base/mutex.h"

namespace cohort {

/// How often something was done and how long it took.
struct CallTimes {
  /// Upper bounds of the bins, in seconds: from the time of a look-up to that of a stuck disk.
  static constexpr std::array<double, 15> kUpperSeconds = {
      0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 25};
  std::array<int64_t, kUpperSeconds.size() + 1> counts{};  ///< Of each bin; the last: longer.
  double seconds = 0;                                      ///< Of all.

  [[nodiscard]] int64_t Count() const {
    return std::accumulate(counts.begin(), counts.end(), int64_t{0});
  }
};

/// Counts CallTimes. Thread-safe.
class CallTimer {
 public:
  void Add(double seconds) {
    const auto bin = std::lower_bound(CallTimes::kUpperSeconds.begin(),
                                      CallTimes::kUpperSeconds.end(), seconds) -
                     CallTimes::kUpperSeconds.begin();
    const MutexLock lock(mutex_);
    ++times_.counts[static_cast<size_t>(bin)];
    times_.seconds += seconds;
  }
  [[nodiscard]] CallTimes Times() const {
    const MutexLock lock(mutex_);
    return times_;
  }

 private:
  mutable Mutex mutex_;
  CallTimes times_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace cohort
