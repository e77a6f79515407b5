#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kChooseBase: the medoid, the mesh with the least mean distance to the others. Cheap: at most 300
/// of the meshes, evenly spaced, are brought to the first of them (coarse pose, ICP on 1000 random
/// vertices), and 500 random vertices of each are looked up in every other.
[[nodiscard]] absl::StatusOr<TaskResult> RunChooseBaseTask(const Task& task,
                                                           const TaskContext& context);

}  // namespace cohort
