#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "common/jobs/estimate.h"

namespace cohort {

/// What a job would take, for people: stages, time, space, and what to think over.
[[nodiscard]] std::string EstimateToText(const Estimate& estimate);
/// The same for scripts.
[[nodiscard]] nlohmann::json EstimateToJson(const Estimate& estimate);

/// What to think over before the job is submitted, a line each, "warning: ..."; empty: nothing.
[[nodiscard]] std::string EstimateWarnings(const Estimate& estimate);

}  // namespace cohort
