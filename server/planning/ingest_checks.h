#pragma once

#include <absl/status/status.h>

#include "server/planning/plan_state.h"

namespace cohort {

/// Whether the sizes of the active meshes fit together: one in metres among others in millimetres
/// would pass every other check and spoil the results.
///
/// RMS radii are compared with each other only: what the unit is, nobody knows.
/// @return kFailedPrecondition naming up to 3 meshes that are more than spec.size_ratio_limit times
///         larger or smaller than the (lower) median; of two meshes, both.
[[nodiscard]] absl::Status CheckSizesFit(const PlanState& state);

}  // namespace cohort
