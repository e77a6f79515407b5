#pragma once

#include <algorithm>

namespace cohort {

/// How long a worker waits before it calls a server again that it could not reach: longer each
/// time, and never so long that leases, also those a restarted server holds open for it, run out
/// between two tries.
class RetryPause {
 public:
  /// @param lease_seconds  of the server, as it last said.
  [[nodiscard]] double Next(double lease_seconds) {
    const double pause = std::min(next_, std::max(kShortest, lease_seconds * kShareOfLease));
    next_ = std::min(2 * next_, kLongest);
    return pause;
  }
  /// The server has answered.
  void Reset() { next_ = kFirst; }

 private:
  static constexpr double kShortest = 0.05;
  static constexpr double kFirst = 0.2;
  static constexpr double kLongest = 10;
  static constexpr double kShareOfLease = 1.0 / 6;  ///< As often as leases are renewed.

  double next_ = kFirst;
};

}  // namespace cohort
