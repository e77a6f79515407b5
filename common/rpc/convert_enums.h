#pragma once

#include <absl/status/statusor.h>

#include "cohort/v1/types.pb.h"
#include "cohort/v1/worker_service.pb.h"
#include "common/jobs/job_state.h"
#include "common/jobs/task.h"

namespace cohort {

// Enumerations <-> wire. FromProto returns kInvalidArgument naming the enumeration and the number
// for 0 (unspecified) and for values that this build does not know.

[[nodiscard]] v1::Method ToProto(Method method);
[[nodiscard]] v1::PoseMode ToProto(PoseMode pose);
[[nodiscard]] v1::ScaleMode ToProto(ScaleMode scale);
[[nodiscard]] v1::Metric ToProto(Metric metric);
[[nodiscard]] v1::Symmetrization ToProto(Symmetrization symmetrization);
[[nodiscard]] v1::Arithmetic ToProto(Arithmetic value);
[[nodiscard]] v1::DistanceSign ToProto(DistanceSign value);
[[nodiscard]] v1::BaseRule ToProto(BaseRule value);
[[nodiscard]] v1::Acceleration ToProto(Acceleration value);
[[nodiscard]] v1::BoundaryPairs ToProto(BoundaryPairs value);
[[nodiscard]] v1::Correspondence ToProto(Correspondence value);
[[nodiscard]] v1::UndersamplingMethod ToProto(UndersamplingMethod value);
[[nodiscard]] v1::Retention ToProto(Retention value);
[[nodiscard]] v1::JobState ToProto(JobState state);
[[nodiscard]] v1::TaskKind ToProto(TaskKind kind);

[[nodiscard]] absl::StatusOr<Method> FromProto(v1::Method wire);
[[nodiscard]] absl::StatusOr<PoseMode> FromProto(v1::PoseMode wire);
[[nodiscard]] absl::StatusOr<ScaleMode> FromProto(v1::ScaleMode wire);
[[nodiscard]] absl::StatusOr<Metric> FromProto(v1::Metric wire);
[[nodiscard]] absl::StatusOr<Symmetrization> FromProto(v1::Symmetrization wire);
[[nodiscard]] absl::StatusOr<Arithmetic> FromProto(v1::Arithmetic wire);
[[nodiscard]] absl::StatusOr<DistanceSign> FromProto(v1::DistanceSign wire);
[[nodiscard]] absl::StatusOr<BaseRule> FromProto(v1::BaseRule wire);
[[nodiscard]] absl::StatusOr<Acceleration> FromProto(v1::Acceleration wire);
[[nodiscard]] absl::StatusOr<BoundaryPairs> FromProto(v1::BoundaryPairs wire);
[[nodiscard]] absl::StatusOr<Correspondence> FromProto(v1::Correspondence wire);
[[nodiscard]] absl::StatusOr<UndersamplingMethod> FromProto(v1::UndersamplingMethod wire);
[[nodiscard]] absl::StatusOr<Retention> FromProto(v1::Retention wire);
[[nodiscard]] absl::StatusOr<JobState> FromProto(v1::JobState wire);
[[nodiscard]] absl::StatusOr<TaskKind> FromProto(v1::TaskKind wire);

}  // namespace cohort
