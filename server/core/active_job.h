#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>

#include "common/jobs/job_state.h"
#include "common/jobs/task.h"
#include "server/planning/job_plan.h"

namespace cohort {

/// A job that is not finished, with its plan; the coordinator's lock covers it.
struct ActiveJob {
  Job job;
  std::unique_ptr<JobPlan> plan;
  std::map<int64_t, Task> open_tasks;  ///< Ready or leased, by number.
  std::set<int64_t> done_tasks;
};

}  // namespace cohort
