#pragma once

#include <atomic>
#include <chrono>

#include "common/base/clock.h"

namespace cohort::testing {

/// A clock that a test moves by hand, also while other threads read it.
class FakeClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime Now() const override { return MonotonicTime(now_.load()); }
  [[nodiscard]] WallTime WallNow() const override { return WallTime(now_.load()); }
  void Advance(double seconds) {
    now_ = now_.load() + std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
  }

 private:
  std::atomic<MonotonicTime::duration> now_{std::chrono::hours(1000)};
};

}  // namespace cohort::testing
