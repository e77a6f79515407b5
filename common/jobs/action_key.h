#pragma once

#include <string>

#include "common/jobs/task.h"

namespace cohort {

/// Grows with every change of what some task's output bytes are, so that results of earlier builds
/// are not taken for those of this one. tests/worker/tasks/results_version_test.cc notices.
inline constexpr int kResultsVersion = 3;

/// Names what a task does: the same key, the same result. A hash of everything in the task but its
/// number, stage and cost, and of kResultsVersion; 64 hexadecimal characters.
/// Indices and names of meshes count, because blobs and messages hold them.
[[nodiscard]] std::string ActionKey(const Task& task);

}  // namespace cohort
