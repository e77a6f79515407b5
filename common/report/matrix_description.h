#pragma once

#include <cstdint>
#include <string>

#include "common/geometry/comparison/metrics.h"
#include "common/jobs/job_spec.h"

namespace cohort {

/// What the numbers of a matrix mean; the words of the plots come from it.
struct MatrixDescription {
  Metric metric = Metric::kRms;
  Method method = Method::kAverage;
  Symmetrization symmetrization = Symmetrization::kMean;
  bool is_preview = false;  ///< Corresponded RMS, not the metric.
  Arithmetic arithmetic = Arithmetic::kExact;
  DistanceSign sign = DistanceSign::kAbsolute;
  std::string unit = "mm";  ///< Of lengths in the mesh files; empty: not known.
  /// For matrices that are not of a metric: what their values are, and how they came about. Empty:
  /// the words for the fields above.
  std::string title = {};
  std::string subtitle = {};
};

/// Unit of the metric's values: "mm", for the variance "mm²"; empty if not known.
[[nodiscard]] std::string ValueUnit(const MatrixDescription& description);

/// "RMS distance"; "RMS distance (signed)"; "Corresponded RMS (preview)".
[[nodiscard]] std::string MetricText(const MatrixDescription& description);

/// "RMS distance (mm)", "RMS distance (signed, mm)"; without the unit if it is not known.
[[nodiscard]] std::string ValueTitle(const MatrixDescription& description);

/// A number with its unit: "1.5 mm".
[[nodiscard]] std::string WithUnit(const std::string& number, const MatrixDescription& description);

/// "Aligned to the mean shape (method average)", "... (method average, preset fidentis)".
[[nodiscard]] std::string MethodText(const MatrixDescription& description);

/// "8 meshes", "1 mesh", "1 pair", "2 pairs".
[[nodiscard]] std::string Counted(int64_t count, const std::string& one, const std::string& many);

}  // namespace cohort
