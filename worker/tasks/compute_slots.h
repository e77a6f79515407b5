#pragma once

#include <deque>
#include <stop_token>
#include <utility>

#include <absl/status/statusor.h>

#include "common/base/mutex.h"

namespace cohort {

/// Lets a number of tasks compute at once while more of them read, write and report: those that
/// wait come in the order of their asking. Thread-safe.
class ComputeSlots {
 public:
  /// The right to compute; given back by its end or by Release, whichever is first.
  class Permit {
   public:
    explicit Permit(ComputeSlots* slots) : slots_(slots) {}
    ~Permit() { Release(); }
    Permit(Permit&& other) noexcept : slots_(std::exchange(other.slots_, nullptr)) {}
    Permit& operator=(Permit&&) = delete;
    Permit(const Permit&) = delete;
    Permit& operator=(const Permit&) = delete;

    void Release() {
      if (ComputeSlots* slots = std::exchange(slots_, nullptr); slots != nullptr) {
        slots->Return();
      }
    }

   private:
    ComputeSlots* slots_;
  };

  /// @param count  >= 1.
  explicit ComputeSlots(int count) : free_(count) {}

  /// Waits for a slot. @return kCancelled once `stop` is requested.
  [[nodiscard]] absl::StatusOr<Permit> Acquire(const std::stop_token& stop);

 private:
  void Return();

  Mutex mutex_;
  CondVar freed_;
  int free_ ABSL_GUARDED_BY(mutex_);
  std::deque<const void*> queue_ ABSL_GUARDED_BY(mutex_);  ///< Who waits, by its stack address.
};

}  // namespace cohort
