#pragma once

#include <string>
#include <vector>

#include "common/jobs/ids.h"
#include "common/jobs/lease.h"
#include "common/jobs/task.h"

namespace cohort {

/// What a worker says when it calls.
struct WorkerReport {
  WorkerId worker;
  std::string build;  ///< WorkerBuild(); the server refuses another than its own.
  std::vector<HeldTask> held;
  int free_slots = 0;
  int spare_slots = 0;      ///< Tasks it would hold ready besides, so as never to wait for one.
  double wait_seconds = 0;  ///< How long the answer may wait for a ready task.
  int slots = 0;            ///< Tasks that it computes at once.
  std::string instruction_set = {};
  bool draining = false;  ///< It ends once its tasks are over.
};

struct GrantedTask {
  Lease lease;
  Task task;
};

/// What a worker is to do.
struct WorkerOrders {
  std::vector<GrantedTask> grants;
  std::vector<Lease> lost;       ///< To be stopped: cancelled, done, or given to another.
  double next_sync_seconds = 0;  ///< Call again after at most this long.
  double lease_seconds = 0;      ///< A worker silent for this long has lost its tasks.
  bool is_wedged = false;        ///< It went on with a task that it was told to stop: it is to end.
};

}  // namespace cohort
