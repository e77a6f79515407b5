#pragma once

#include <chrono>

namespace cohort {

/// Monotonic instant; leases and deadlines are measured with it.
using MonotonicTime = std::chrono::steady_clock::time_point;
/// Calendar instant; for display and records only, never for decisions.
using WallTime = std::chrono::system_clock::time_point;

/// Where time comes from, so that tests can move it by hand. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual MonotonicTime Now() const = 0;
  [[nodiscard]] virtual WallTime WallNow() const = 0;
};

/// The machine's clocks.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime Now() const override { return std::chrono::steady_clock::now(); }
  [[nodiscard]] WallTime WallNow() const override { return std::chrono::system_clock::now(); }
};

}  // namespace cohort
