#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "common/jobs/job_state.h"
#include "server/catalog/catalog.h"
#include "server/planning/job_plan.h"
#include "server/scheduling/number_set.h"
#include "server/scheduling/scheduler.h"

namespace cohort {

/// A job that is not finished, with its plan; the coordinator's lock covers it.
struct ActiveJob {
  Job job;
  std::unique_ptr<JobPlan> plan;
  JobOutputs kept;                          ///< Of a reference job; see JobPlan::Create.
  NumberSet unlooked;                       ///< Ready tasks; not looked up among known results.
  std::map<int64_t, std::string> given_up;  ///< Tasks that failed too often, and why.
  int64_t reused = 0;                       ///< Tasks whose result was known.
  /// Begun by another build whose tasks had other numbers: only our own leases count.
  bool is_started_over = false;
  /// Attempts at tasks that are not ready again: a damaged blob has put the job back.
  std::map<int64_t, TaskAttempts> earlier_attempts;
};

/// The row of a task that has no result (yet).
inline TaskRecord RecordOf(int64_t number, const TaskAttempts& attempts) {
  TaskRecord record;
  record.number = number;
  record.epoch = attempts.epoch;
  record.failures = attempts.failures;
  record.losses = attempts.losses;
  return record;
}

}  // namespace cohort
