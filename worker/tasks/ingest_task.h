#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kIngest: raw files -> checked canonical meshes; a bad file is a rejection, not a failure.
/// @return as BlobStore::Get and Put.
[[nodiscard]] absl::StatusOr<TaskResult> RunIngestTask(const Task& task,
                                                       const TaskContext& context);

}  // namespace cohort
