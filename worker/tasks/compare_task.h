#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// kCompare: every metric of every directed pair between the meshes of two blocks.
[[nodiscard]] absl::StatusOr<TaskResult> RunCompareTask(const Task& task,
                                                        const TaskContext& context);

/// kAlignAndCompare: aligns every mesh to the one target and measures it there. A pair that cannot
/// be aligned gets NaN in every metric.
[[nodiscard]] absl::StatusOr<TaskResult> RunAlignAndCompareTask(const Task& task,
                                                                const TaskContext& context);

}  // namespace cohort
