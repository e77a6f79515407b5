#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/jobs/job_state.h"
#include "server/catalog/catalog_session.h"

namespace cohort {

// Rows of the table job. Only for bodies of Database: they throw what SOCI throws.

/// "j-000012" of 12.
[[nodiscard]] JobId JobIdOf(int64_t number);
/// Inverse of JobIdOf.
/// @return kNotFound naming the job if there cannot be one of that name.
[[nodiscard]] absl::StatusOr<int64_t> NumberOf(const JobId& id);
[[nodiscard]] absl::Status NoSuchJob(const JobId& id);

/// Jobs of "SELECT ... FROM job <rest>"; `bind` exchanges the parameters of `rest` in order.
[[nodiscard]] absl::StatusOr<std::vector<Job>> SelectJobs(
    soci::session& sql, const std::string& rest, const std::function<void(soci::statement&)>& bind);
/// @return kNotFound naming the job.
[[nodiscard]] absl::StatusOr<Job> SelectJob(soci::session& sql, const JobId& id);

/// `job.id` must be that of a number not given out before.
[[nodiscard]] absl::Status InsertJob(soci::session& sql,
                                     const Job& job,
                                     const std::string& request_id,
                                     const JobOutputs& outputs);
/// What Catalog::UpdateJob writes. @return kNotFound naming the job.
[[nodiscard]] absl::Status UpdateJobRow(CatalogSession& sql, const Job& job);
/// The number of a job that is there. @return kNotFound naming the job.
[[nodiscard]] absl::StatusOr<int64_t> RequireJob(CatalogSession& sql, const JobId& id);

}  // namespace cohort
