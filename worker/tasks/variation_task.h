#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kVariation: distance of every reference vertex to its nearest vertex of each aligned mesh.
[[nodiscard]] absl::StatusOr<TaskResult> RunVariationTask(const Task& task,
                                                          const TaskContext& context);

/// kSummarize: every metric over the meshes for each reference vertex, and the mean shape.
[[nodiscard]] absl::StatusOr<TaskResult> RunSummarizeTask(const Task& task,
                                                          const TaskContext& context);

}  // namespace cohort
