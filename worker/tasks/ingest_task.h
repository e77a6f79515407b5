#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kIngest: raw files -> checked canonical meshes; a bad file is a rejection, not a failure. With 0
/// position bits the meshes are kept as in their files (FileMesh).
/// @return as BlobStore::Get and Put.
[[nodiscard]] absl::StatusOr<TaskResult> RunIngestTask(const Task& task,
                                                       const TaskContext& context);

}  // namespace cohort
