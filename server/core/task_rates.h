#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/jobs/job_spec.h"

namespace cohort {

/// How long tasks really take for each second of their expected cost, by kind: a running average
/// that forgets what lies more than some hundred tasks back. Not thread-safe.
class TaskRates {
 public:
  /// A task was done. @param kind  KindOf; `cost` as planned; `seconds` as its worker says.
  void Note(const std::string& kind, double cost, double seconds);
  /// Seconds for each second of cost; nothing before such a task was done.
  [[nodiscard]] std::optional<double> RateOf(const std::string& kind) const;

  /// Tasks of one kind cost the same for each vertex: the stage ("align 2" and "align 3" are one),
  /// and of the options those that the costs leave out.
  [[nodiscard]] static std::string KindOf(const JobSpec& spec, const std::string& stage);

 private:
  struct Sums {
    double cost = 0;
    double seconds = 0;
  };
  std::map<std::string, Sums> sums_;
};

}  // namespace cohort
