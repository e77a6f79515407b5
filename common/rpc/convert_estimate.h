#pragma once

#include <absl/status/statusor.h>

#include "cohort/v1/job_service.pb.h"
#include "common/jobs/estimate.h"

namespace cohort {

[[nodiscard]] v1::Estimate ToProto(const Estimate& estimate);
/// @return as the conversions of convert.h.
[[nodiscard]] absl::StatusOr<Estimate> FromProto(const v1::Estimate& wire);

}  // namespace cohort
