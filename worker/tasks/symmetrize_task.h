#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kSymmetrize: the symmetric copy of each mesh (MakeSymmetric) as a raw mesh blob of its own. A
/// mesh whose mirrored copy cannot be aligned with it is rejected.
[[nodiscard]] absl::StatusOr<TaskResult> RunSymmetrizeTask(const Task& task,
                                                           const TaskContext& context);

}  // namespace cohort
