#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/jobs/job_spec.h"

namespace cohort {

/// What the tasks of one stage take.
struct StageEstimate {
  std::string name;
  int64_t tasks = 0;
  double core_seconds = 0;
  bool is_measured = false;  ///< By what such tasks took on this server; else by assumed rates.
};

/// What a job would take, told before it is submitted. All of it counts: what is known from
/// earlier jobs makes it cheaper.
struct Estimate {
  int64_t meshes = 0;
  int64_t pairs = 0;  ///< Directed ones to be measured.
  std::vector<StageEstimate> stages;
  int slots = 0;            ///< Tasks that the workers of now compute at once.
  double wall_seconds = 0;  ///< With those; 0 without any.

  Retention retention = Retention::kMetrics;    ///< The job's; Retention::kAuto decided.
  std::map<Retention, int64_t> distance_bytes;  ///< What each retention would write.
  int64_t other_bytes = 0;                      ///< Written besides, whatever the retention.
  std::optional<int64_t> free_bytes;            ///< Of the store, for jobs; nothing: not known.

  /// Of Method::kEach: what Method::kAverage with the same options would take; else 0.
  double average_core_seconds = 0;

  [[nodiscard]] double CoreSeconds() const {
    double sum = 0;
    for (const StageEstimate& stage : stages) {
      sum += stage.core_seconds;
    }
    return sum;
  }
  /// How much of CoreSeconds goes by measured rates, 0 to 1.
  [[nodiscard]] double MeasuredShare() const {
    double sum = 0;
    for (const StageEstimate& stage : stages) {
      sum += stage.is_measured ? stage.core_seconds : 0;
    }
    return sum > 0 ? sum / CoreSeconds() : 0;
  }
  /// What the job would write.
  [[nodiscard]] int64_t BytesWritten() const {
    const auto found = distance_bytes.find(retention);
    return other_bytes + (found == distance_bytes.end() ? 0 : found->second);
  }
  [[nodiscard]] bool Fits() const { return !free_bytes || BytesWritten() <= *free_bytes; }
};

}  // namespace cohort
