#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

// Tasks of Arithmetic::kFidentis. Their numbers are those of the library (fidentis_icp.h,
// fidentis_mean_shape.h, fidentis_metrics.h) to the last bit, however the job is cut into tasks.

/// kAlign: ICP of each mesh to the reference, from where the last round put it. Also writes the
/// moved meshes. A mesh that cannot be aligned is rejected.
[[nodiscard]] absl::StatusOr<TaskResult> RunFidentisAlignTask(const Task& task,
                                                              const TaskContext& context);

/// kAverage: the next reference: the last one moved by the mean step to all placed meshes.
[[nodiscard]] absl::StatusOr<TaskResult> RunFidentisAverageTask(const Task& task,
                                                                const TaskContext& context);

/// kCompare: every metric of every directed pair between the placed meshes of two blocks.
[[nodiscard]] absl::StatusOr<TaskResult> RunFidentisCompareTask(const Task& task,
                                                                const TaskContext& context);

/// kAlignAndCompare: aligns every mesh to the one target and measures it there. A pair that cannot
/// be aligned gets NaN in every metric.
[[nodiscard]] absl::StatusOr<TaskResult> RunFidentisAlignAndCompareTask(const Task& task,
                                                                        const TaskContext& context);

/// kSummarize: the surface on which the predecessor draws its variation map (the placed base mesh,
/// moved by one averaging step), and every metric of its vertices' distances to all placed meshes.
[[nodiscard]] absl::StatusOr<TaskResult> RunFidentisSummarizeTask(const Task& task,
                                                                  const TaskContext& context);

}  // namespace cohort
