#pragma once

#include <absl/status/statusor.h>

#include "cohort/v1/result_service.pb.h"
#include "common/jobs/job_state.h"

namespace cohort {

/// All but the preview, which has a call of its own.
[[nodiscard]] v1::GetOutputsResponse ToProto(const JobOutputs& outputs);
/// @return as the conversions of convert.h.
[[nodiscard]] absl::StatusOr<JobOutputs> FromProto(const v1::GetOutputsResponse& wire);

}  // namespace cohort
