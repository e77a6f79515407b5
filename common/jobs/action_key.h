#pragma once

#include <string>

#include "common/jobs/job_spec.h"
#include "common/jobs/task.h"

namespace cohort {

/// Grows with every change of what some task's output bytes are, so that results of earlier builds
/// are not taken for those of this one. tests/worker/tasks/results_version_test.cc notices.
inline constexpr int kResultsVersion = 4;

/// Names tasks by what they do: the same key, the same result. A hash of everything in the task but
/// its number, stage and cost, and of kResultsVersion. Indices and names of meshes count, because
/// blobs and messages hold them. Not thread-safe.
class ActionKeys {
 public:
  ActionKeys();
  /// @return 64 hexadecimal characters.
  [[nodiscard]] std::string Of(const Task& task);

 private:
  JobSpec options_;  ///< Those of the task before: most tasks of a job have the same.
  std::string options_text_;
};

}  // namespace cohort
