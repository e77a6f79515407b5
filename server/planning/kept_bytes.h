#pragma once

#include "common/jobs/job_spec.h"
#include "server/planning/plan_state.h"

namespace cohort {

/// Bytes that keeping the distances of all pairs of the job takes, roughly; those that a reference
/// job has kept included.
[[nodiscard]] double BytesKept(const PlanState& state, Retention retention);

/// The job's options with Retention::kAuto decided: by the meshes alone, so that every task, also
/// after a restart, decides the same.
[[nodiscard]] CompareOptions ResolvedCompare(const PlanState& state);

}  // namespace cohort
