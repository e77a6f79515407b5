#include "worker/tasks/compute_slots.h"

namespace cohort {

absl::StatusOr<ComputeSlots::Permit> ComputeSlots::Acquire(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] {
    // Under the lock, so that it does not fall between a look at the token and the wait.
    const MutexLock lock(mutex_);
    freed_.NotifyAll();
  });
  const MutexLock lock(mutex_);
  const void* self = &wake;
  queue_.push_back(self);
  while (!stop.stop_requested() && (free_ == 0 || queue_.front() != self)) {
    freed_.Wait(mutex_);
  }
  std::erase(queue_, self);
  freed_.NotifyAll();  // Another is at the front now.
  if (stop.stop_requested()) {
    return absl::CancelledError("stopped before it began to compute");
  }
  --free_;
  return Permit(this);
}

void ComputeSlots::Return() {
  const MutexLock lock(mutex_);
  ++free_;
  freed_.NotifyAll();
}

}  // namespace cohort
