#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/jobs/job_state.h"
#include "common/jobs/worker_status.h"

namespace cohort {

/// Workers for scripts (`--json`).
[[nodiscard]] nlohmann::json WorkersToJson(const std::vector<WorkerStatus>& workers);

/// Workers as an aligned table, one a line.
[[nodiscard]] std::string WorkersToTable(const std::vector<WorkerStatus>& workers);

/// What is going on: totals, the jobs that have not ended, the tasks longest out.
/// @param most_tasks  tasks shown; of more the number is told.
[[nodiscard]] std::string Overview(const std::vector<Job>& jobs,
                                   const std::vector<WorkerStatus>& workers,
                                   size_t most_tasks);

}  // namespace cohort
