#pragma once

#include <optional>

#include <absl/status/statusor.h>

#include "common/jobs/worker_protocol.h"

namespace cohort {

/// What a worker asks of the server. Thread-safe.
class CoordinatorLink {
 public:
  virtual ~CoordinatorLink() = default;
  [[nodiscard]] virtual absl::StatusOr<WorkerOrders> Synchronize(const WorkerReport& report) = 0;
  /// @param report the next report, made as if the task were over; none: only says the result
  /// @return what Synchronize would answer to `report`, without waiting; none: call it to hear
  [[nodiscard]] virtual absl::StatusOr<std::optional<WorkerOrders>> CompleteTask(
      const WorkerId& worker,
      const Lease& lease,
      const TaskResult& result,
      const std::optional<WorkerReport>& report) = 0;
  [[nodiscard]] virtual absl::Status ReleaseTask(const WorkerId& worker, const Lease& lease) = 0;
  [[nodiscard]] virtual absl::Status FailTask(const WorkerId& worker,
                                              const Lease& lease,
                                              const absl::Status& failure) = 0;
  /// Makes a Synchronize that waits, and those to come, return kCancelled at once.
  virtual void CancelSynchronize() = 0;
};

}  // namespace cohort
