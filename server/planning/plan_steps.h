#pragma once

#include <memory>
#include <vector>

#include "common/jobs/job_spec.h"
#include "server/planning/stage.h"

namespace cohort {

/// Stages that run together; the next step starts when all their tasks are finished.
using Step = std::vector<std::unique_ptr<const Stage>>;

/// All steps of a job, first to last.
[[nodiscard]] std::vector<Step> MakeSteps(const JobSpec& spec);

}  // namespace cohort
