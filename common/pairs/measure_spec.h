#pragma once

#include <optional>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/comparison/measure_field.h"
#include "common/geometry/comparison/metrics.h"

namespace cohort {

/// Which number of the distances of a directed pair is asked for, once a job is done.
struct MeasureSpec {
  Metric metric = Metric::kRms;
  std::optional<double> percentile;  ///< Share in [0, 1], in place of `metric`.
  double lower_share = 0;            ///< Thresholds, as FieldOptions.
  double upper_share = 1;
  DistanceSign sign = DistanceSign::kAbsolute;
  bool by_area = false;  ///< Each vertex counts as much as the surface it stands for.

  /// One of the metrics that every job has for all its pairs.
  [[nodiscard]] bool IsPlainMetric() const {
    return !percentile && lower_share == 0 && upper_share == 1 && sign == DistanceSign::kAbsolute &&
           !by_area;
  }
  [[nodiscard]] FieldOptions ToFieldOptions() const;
  /// The number asked for.
  [[nodiscard]] double ValueOf(const FieldMeasure& measure) const {
    return percentile ? measure.percentile : measure.metrics[static_cast<size_t>(metric)];
  }
  /// As ParseMeasure reads it: "rms", "p95", "p99.5".
  [[nodiscard]] std::string Name() const;
  /// For titles, without the unit: "RMS distance", "95th percentile of the distances", with what
  /// else is asked in brackets: "Mean distance (signed, by area, from 0.1 to 0.9)".
  [[nodiscard]] std::string Title() const;
};

/// "rms", "mean", "geometric-mean", "min", "max", "variance", or "p" and a percentage from 0 to
/// 100: "p95", "p99.5". "p75" is the metric of that name.
/// @return kInvalidArgument naming the text and what was expected.
[[nodiscard]] absl::StatusOr<MeasureSpec> ParseMeasure(const std::string& text);

}  // namespace cohort
