#pragma once

#include <optional>
#include <string_view>

#include "common/jobs/job_spec.h"

namespace cohort {

// Names that only the JSON form of a job spec needs; the others are in job_spec.h.

[[nodiscard]] std::string_view ScaleModeName(ScaleMode mode);
[[nodiscard]] std::optional<ScaleMode> ScaleModeFromName(std::string_view name);
[[nodiscard]] std::optional<BaseRule> BaseRuleFromName(std::string_view name);

}  // namespace cohort
