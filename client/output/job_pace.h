#pragma once

#include <cstdint>
#include <optional>

#include "common/jobs/job_state.h"

namespace cohort {

/// How fast a job gets on: by what was seen of it, and while that is too little, by how long it
/// has run. What was known from earlier jobs, and the time that a job was held, count for nothing.
/// Not thread-safe.
class JobPace {
 public:
  /// To be called with every state of the job, in order.
  /// @param elapsed_seconds  since it is watched; monotonic.
  /// @param now_unix_ms  this machine's clock; a server's that is ahead of it costs the first
  ///                     estimate only.
  void Note(const Job& job, double elapsed_seconds, int64_t now_unix_ms);

  /// While it was watched; 0: none was done.
  [[nodiscard]] double TasksPerSecond() const;
  /// Until the job has ended; nothing while that cannot be told, or the job is held.
  [[nodiscard]] std::optional<double> RemainingSeconds() const;

 private:
  struct Sample {
    double elapsed_seconds = 0;
    double cost_done = 0;
    int64_t tasks_done = 0;
  };
  [[nodiscard]] std::optional<double> RemainingByAge(double cost_left) const;

  std::optional<Sample> first_;  ///< Since when it goes on without a stop.
  Sample last_;
  Job job_;
  double age_seconds_ = 0;
  bool age_tells_ = true;  ///< The job was not seen being held.
};

}  // namespace cohort
