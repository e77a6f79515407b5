#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <utility>

#include <absl/status/statusor.h>

#include "common/jobs/lease.h"
#include "common/jobs/task.h"
#include "common/store/blob_store.h"
#include "worker/tasks/compute_slots.h"
#include "worker/tasks/mesh_cache.h"

namespace cohort {

/// What a task tells while it runs, on its own thread; null: nobody listens.
struct TaskHooks {
  std::function<void()> on_begin = {};     ///< It has got its slot.
  std::function<void()> on_computed = {};  ///< It has given it back, and only writes from now on.
};

/// Runs tasks: the kind picks the function. Thread-safe.
class TaskRunner {
 public:
  static constexpr int kUnlimited = 1 << 20;

  /// @param slots  tasks that may compute at once; more of them may read and write.
  TaskRunner(BlobStore& store, MeshCache& meshes, int slots = kUnlimited)
      : store_(store), meshes_(meshes), slots_(slots) {}

  /// Same task, same output bytes, whoever runs it. What libraries throw ends here.
  /// Waits for a slot first.
  /// @return kCancelled after `stop`; kInvalidArgument, kDataLoss, kFailedPrecondition if the task
  ///         cannot succeed anywhere; other codes if another try may.
  [[nodiscard]] absl::StatusOr<TaskResult> Run(const Task& task, std::stop_token stop) {
    std::atomic<int64_t> ticks = HeldTask::kNotBegun;
    return Run(task, std::move(stop), ticks);
  }
  /// @param ticks  HeldTask::ticks, kept up to date.
  [[nodiscard]] absl::StatusOr<TaskResult> Run(const Task& task,
                                               std::stop_token stop,
                                               std::atomic<int64_t>& ticks,
                                               const TaskHooks& hooks = {});

 private:
  BlobStore& store_;
  MeshCache& meshes_;
  ComputeSlots slots_;
};

}  // namespace cohort
