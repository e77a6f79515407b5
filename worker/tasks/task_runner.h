#pragma once

#include <stop_token>

#include <absl/status/statusor.h>

#include "common/jobs/task.h"
#include "common/store/blob_store.h"
#include "worker/tasks/mesh_cache.h"

namespace cohort {

/// Runs tasks: the kind picks the function. Thread-safe.
class TaskRunner {
 public:
  TaskRunner(BlobStore& store, MeshCache& meshes) : store_(store), meshes_(meshes) {}

  /// Same task, same output bytes, whoever runs it. What libraries throw ends here.
  /// @return kCancelled after `stop`; kInvalidArgument, kDataLoss, kFailedPrecondition if the task
  ///         cannot succeed anywhere; other codes if another try may.
  [[nodiscard]] absl::StatusOr<TaskResult> Run(const Task& task, std::stop_token stop);

 private:
  BlobStore& store_;
  MeshCache& meshes_;
};

}  // namespace cohort
