#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// Corresponded RMS of the meshes in `meshes` with those in `targets`, from the correspondence
/// blobs in `partials` that together hold them.
/// @return kDataLoss if one of them is missing or over other vertices.
[[nodiscard]] absl::StatusOr<TaskResult> RunPreviewTask(const Task& task,
                                                        const TaskContext& context);

}  // namespace cohort
