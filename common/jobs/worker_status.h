#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/jobs/ids.h"
#include "common/jobs/lease.h"

namespace cohort {

/// A task that a worker holds.
struct RunningTask {
  HeldTask held;
  std::string stage;   ///< Empty: the task is no longer wanted.
  double seconds = 0;  ///< Since it was handed out.
};

/// A worker as people see it.
struct WorkerStatus {
  WorkerId worker;
  std::string instruction_set;
  int slots = 0;  ///< Tasks that it computes at once.
  bool is_draining = false;
  double silent_seconds = 0;  ///< Since it last called.
  int64_t first_seen_unix_ms = 0;
  int64_t tasks_done = 0;  ///< Results taken from it since the server started.
  int64_t tasks_failed = 0;
  double busy_seconds = 0;           ///< What the tasks done took.
  std::vector<RunningTask> running;  ///< As it last said.
};

}  // namespace cohort
