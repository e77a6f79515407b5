#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "common/base/call_times.h"
#include "common/jobs/job_state.h"

namespace cohort {

/// Tasks done of one kind of stage.
struct DoneTasks {
  int64_t count = 0;
  double seconds = 0;  ///< What their workers took.
};

/// What has happened since the server started.
struct EventTotals {
  std::map<std::string, DoneTasks, std::less<>> done;  ///< By StageKind.
  int64_t tasks_failed = 0;      ///< Attempts; the task may have been tried again.
  int64_t tasks_lost = 0;        ///< Attempts, with their workers.
  int64_t tasks_superseded = 0;  ///< Results not taken: done already, or not wanted any more.
  int64_t tasks_reused = 0;      ///< Not done: their results were known.
  int64_t tasks_given_up = 0;
  std::map<JobState, int64_t> jobs_ended;

  void NoteDone(std::string_view kind, double seconds) {
    DoneTasks& tasks = done[std::string(kind)];
    ++tasks.count;
    tasks.seconds += seconds;
  }
};

/// What those who watch over a server want to know of its coordinator.
struct CoordinatorFigures {
  int64_t tasks_ready = 0;  ///< Wait for a worker or for the end of their back-off.
  int64_t tasks_leased = 0;
  double ready_wait_seconds = 0;     ///< How long tasks have been ready and none was handed out.
  std::map<JobState, int64_t> jobs;  ///< Those that have not ended.
  int64_t workers = 0;               ///< Heard of within a lease time; also those that drain.
  int64_t workers_draining = 0;
  int64_t slots = 0;  ///< Of workers that do not drain.
  int64_t slots_busy = 0;
  EventTotals totals;
  int64_t second_copies = 0;  ///< Handed out of slow tasks, since the server started.
  CallTimes synchronize;      ///< Without the time that calls wait for a task.
  CallTimes complete;
  CallTimes catalog_writes;  ///< Transactions.
};

/// "align" of "align 2".
[[nodiscard]] inline std::string_view StageKind(std::string_view stage) {
  return stage.substr(0, stage.find(' '));
}

}  // namespace cohort
