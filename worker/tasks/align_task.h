#pragma once

#include "worker/tasks/task_context.h"

namespace cohort {

/// Scaling ICP of one mesh under the task's options, with the vertices that its undersampling
/// keeps.
/// @return as SelectVertices and AlignByIcp.
[[nodiscard]] absl::StatusOr<Alignment> AlignMesh(const Task& task,
                                                  const TaskMesh& source,
                                                  const IcpMesh& target,
                                                  const Similarity& T_target_source,
                                                  const TaskContext& context,
                                                  PacketSearch& search);

/// kPose: a coarse pose for each mesh (PoseFinder). A mesh that none is found for is rejected.
[[nodiscard]] absl::StatusOr<TaskResult> RunPoseTask(const Task& task, const TaskContext& context);

/// kAlign: scaling ICP of each mesh to the reference, from its coarse pose or from where it was
/// aligned before; and what the task wants of the displacements of the reference's vertices to the
/// aligned meshes. A mesh that cannot be aligned is rejected.
[[nodiscard]] absl::StatusOr<TaskResult> RunAlignTask(const Task& task, const TaskContext& context);

/// kAverage: the next reference.
[[nodiscard]] absl::StatusOr<TaskResult> RunAverageTask(const Task& task,
                                                        const TaskContext& context);

}  // namespace cohort
