#pragma once

#include <map>
#include <string>
#include <vector>

#include <prometheus/metric_family.h>

#include "common/base/call_times.h"

namespace cohort {

/// One value of a metric.
struct MetricValue {
  double value = 0;
  std::map<std::string, std::string> labels;
};

/// What a process tells of itself at one moment, as Prometheus reads it. Names end as its
/// conventions ask: counters in _total, times in _seconds, sizes in _bytes. Not thread-safe.
class MetricPage {
 public:
  /// A value that goes up and down. @param help  one line.
  void AddGauge(const std::string& name, const std::string& help, double value);
  void AddGauge(const std::string& name,
                const std::string& help,
                const std::vector<MetricValue>& values);
  /// A value that only grows, from 0 at the start of the process.
  void AddCounter(const std::string& name, const std::string& help, double value);
  void AddCounter(const std::string& name,
                  const std::string& help,
                  const std::vector<MetricValue>& values);
  void AddHistogram(const std::string& name, const std::string& help, const CallTimes& times);
  /// cohort_build_info{version=...} and when the process started: what every page has.
  /// @param program  "cohort-server".
  void AddProcess(const std::string& program, double start_unix_seconds);

  /// Text exposition format 0.0.4.
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] const std::vector<prometheus::MetricFamily>& Families() const { return families_; }

 private:
  void Add(prometheus::MetricType type,
           const std::string& name,
           const std::string& help,
           const std::vector<MetricValue>& values);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace cohort
