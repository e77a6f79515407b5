#pragma once

#include <chrono>

#include "common/base/clock.h"

namespace cohort::testing {

/// A clock that a test moves by hand.
class FakeClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime Now() const override { return now_; }
  [[nodiscard]] WallTime WallNow() const override { return WallTime(now_.time_since_epoch()); }
  void Advance(double seconds) {
    now_ += std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
  }

 private:
  MonotonicTime now_{std::chrono::hours(1000)};
};

}  // namespace cohort::testing
