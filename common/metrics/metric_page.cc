#include "common/metrics/metric_page.h"

#include <cstdint>
#include <utility>

#include <prometheus/text_serializer.h>

#include "common/base/version.h"

namespace cohort {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

void MetricPage::AddGauge(const std::string& name, const std::string& help, double value) {
  Add(MetricType::Gauge, name, help, {{.value = value, .labels = {}}});
}

void MetricPage::AddGauge(const std::string& name,
                          const std::string& help,
                          const std::vector<MetricValue>& values) {
  Add(MetricType::Gauge, name, help, values);
}

void MetricPage::AddCounter(const std::string& name, const std::string& help, double value) {
  Add(MetricType::Counter, name, help, {{.value = value, .labels = {}}});
}

void MetricPage::AddCounter(const std::string& name,
                            const std::string& help,
                            const std::vector<MetricValue>& values) {
  Add(MetricType::Counter, name, help, values);
}

void MetricPage::Add(MetricType type,
                     const std::string& name,
                     const std::string& help,
                     const std::vector<MetricValue>& values) {
  MetricFamily& family = families_.emplace_back();
  family.name = name;
  family.help = help;
  family.type = type;
  for (const MetricValue& value : values) {
    ClientMetric& metric = family.metric.emplace_back();
    for (const auto& [label, text] : value.labels) {
      metric.label.push_back({label, text});
    }
    metric.gauge.value = value.value;
    metric.counter.value = value.value;
  }
}

void MetricPage::AddHistogram(const std::string& name,
                              const std::string& help,
                              const CallTimes& times) {
  MetricFamily& family = families_.emplace_back();
  family.name = name;
  family.help = help;
  family.type = MetricType::Histogram;
  ClientMetric::Histogram& histogram = family.metric.emplace_back().histogram;
  histogram.sample_count = static_cast<uint64_t>(times.Count());
  histogram.sample_sum = times.seconds;
  uint64_t below = 0;
  for (size_t bin = 0; bin < CallTimes::kUpperSeconds.size(); ++bin) {
    below += static_cast<uint64_t>(times.counts[bin]);
    // The serializer adds the bucket +Inf.
    histogram.bucket.push_back(
        {.cumulative_count = below, .upper_bound = CallTimes::kUpperSeconds[bin]});
  }
}

void MetricPage::AddProcess(const std::string& program, double start_unix_seconds) {
  AddGauge(
      "cohort_build_info", "1; the labels say what runs.",
      {{.value = 1, .labels = {{"program", program}, {"version", std::string(BuildVersion())}}}});
  AddGauge("cohort_process_start_time_seconds", "When the process started, Unix time.",
           start_unix_seconds);
}

std::string MetricPage::Text() const {
  return prometheus::TextSerializer().Serialize(families_);
}

}  // namespace cohort
