#pragma once

#include <absl/status/status.h>

#include "server/planning/plan_state.h"

namespace cohort {

/// Whether a result answers its task, so that no worker's mistake reaches the plan.
///
/// @return kInvalidArgument naming the task and what is missing or too much: a mesh that ingest
///         neither took nor rejected, a blob that is not named, an index that is not the task's.
[[nodiscard]] absl::Status CheckResult(const PlanState& state,
                                       const Task& task,
                                       const TaskResult& result);

}  // namespace cohort
