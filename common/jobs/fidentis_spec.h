#pragma once

#include <absl/status/status.h>

#include "common/jobs/job_spec.h"

namespace cohort {

/// The preset "fidentis": what the predecessor does unless told otherwise, with scale. Method
/// average: I = 10 per round, M = 3; one and each: I = 40, as the thesis's tables use; e = 0.05,
/// meshes as in their files, no coarse pose.
///
/// Of its options a job may change: base (a name), rounds, scale (from-x, off), max_iterations,
/// tolerance, sign, retention (vectors, metrics, auto), and what is made of the matrix afterwards.
/// Source: reference c3-c8 and (f).
[[nodiscard]] JobSpec FidentisSpec(Method method);

/// Whether a spec with Arithmetic::kFidentis asks for nothing that the predecessor does not have.
/// @return kInvalidArgument naming the field, its value and what was expected.
[[nodiscard]] absl::Status ValidateFidentis(const JobSpec& spec);

}  // namespace cohort
