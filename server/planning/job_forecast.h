#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/jobs/job_spec.h"
#include "server/planning/plan_state.h"

namespace cohort {

/// The tasks of one stage.
struct StageForecast {
  std::string name;
  int64_t tasks = 0;
  double cost = 0;     ///< Of all, Task::cost: rough seconds on one slot.
  double longest = 0;  ///< Of the most expensive one.
};

/// What a job takes, before it is done. From the meshes that ingest knows, and from the sizes of
/// the files of the others.
struct JobForecast {
  int64_t meshes = 0;
  int64_t pairs = 0;  ///< Directed ones to be measured, of different meshes.
  std::vector<StageForecast> stages;
  Retention retention = Retention::kMetrics;   ///< Retention::kAuto decided.
  std::map<Retention, double> distance_bytes;  ///< What each retention writes for those pairs.
  double other_bytes = 0;  ///< Meshes, alignments, metrics, sums: whatever the retention.
};

/// All but the stages. @param state  of a plan at its beginning.
[[nodiscard]] JobForecast ForecastOf(const PlanState& state);

}  // namespace cohort
