#pragma once

#include <absl/status/statusor.h>

#include "cohort/v1/admin_service.pb.h"
#include "cohort/v1/types.pb.h"
#include "cohort/v1/worker_service.pb.h"
#include "common/jobs/job_state.h"
#include "common/jobs/lease.h"
#include "common/jobs/task.h"
#include "common/jobs/worker_status.h"

namespace cohort {

// Plain structs <-> messages: the only place that converts. ToProto cannot fail; FromProto returns
// kInvalidArgument, naming the field, for unknown enum values, bad digests and wrong array lengths.

[[nodiscard]] v1::JobSpec ToProto(const JobSpec& spec);
[[nodiscard]] v1::Counters ToProto(const Counters& counters);
[[nodiscard]] v1::Job ToProto(const Job& job);
[[nodiscard]] v1::SetMesh ToProto(const SetMesh& mesh);
[[nodiscard]] v1::IngestedMesh ToProto(const IngestedMesh& mesh);
[[nodiscard]] v1::JobMesh ToProto(const JobMesh& mesh);
[[nodiscard]] v1::Metric ToProto(Metric metric);
[[nodiscard]] v1::Lease ToProto(const Lease& lease);
[[nodiscard]] v1::HeldTask ToProto(const HeldTask& held);
[[nodiscard]] v1::Worker ToProto(const WorkerStatus& status);
[[nodiscard]] v1::Task ToProto(const Task& task);
[[nodiscard]] v1::TaskResult ToProto(const TaskResult& result);

[[nodiscard]] absl::StatusOr<JobSpec> FromProto(const v1::JobSpec& wire);
[[nodiscard]] Counters FromProto(const v1::Counters& wire);
[[nodiscard]] absl::StatusOr<Job> FromProto(const v1::Job& wire);
[[nodiscard]] absl::StatusOr<SetMesh> FromProto(const v1::SetMesh& wire);
[[nodiscard]] absl::StatusOr<IngestedMesh> FromProto(const v1::IngestedMesh& wire);
[[nodiscard]] absl::StatusOr<JobMesh> FromProto(const v1::JobMesh& wire);
[[nodiscard]] absl::StatusOr<Metric> FromProto(v1::Metric wire);
[[nodiscard]] Lease FromProto(const v1::Lease& wire);
[[nodiscard]] HeldTask FromProto(const v1::HeldTask& wire);
[[nodiscard]] WorkerStatus FromProto(const v1::Worker& wire);
[[nodiscard]] absl::StatusOr<Task> FromProto(const v1::Task& wire);
[[nodiscard]] absl::StatusOr<TaskResult> FromProto(const v1::TaskResult& wire);

}  // namespace cohort
