#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cohort {

/// One number from a field of absolute distances. The order is the predecessor's menu and the order
/// of values in tile blobs: append only.
enum class Metric : uint8_t {
  kRms,            ///< sqrt(sum d^2 / n)
  kMean,           ///< sum d / n
  kGeometricMean,  ///< exp(sum ln d / n); 0 if any d is 0
  kMin,
  kMax,           ///< Directed Hausdorff distance.
  kVariance,      ///< sum (d - mean)^2 / n; square units
  kPercentile75,  ///< sorted[trunc(0.75 n - 0.5)], 0-based, ascending
};
inline constexpr int kMetricCount = 7;
inline constexpr std::array<Metric, kMetricCount> kAllMetrics = {
    Metric::kRms, Metric::kMean,     Metric::kGeometricMean, Metric::kMin,
    Metric::kMax, Metric::kVariance, Metric::kPercentile75};

/// Whether the side of the target on which a vertex lies counts: signed distances are positive in
/// front of it (see SignedDistances).
enum class DistanceSign : uint8_t { kAbsolute, kSigned };

/// "rms", "mean", "geometric-mean", "min", "max", "variance", "p75": command line and files.
[[nodiscard]] std::string_view MetricName(Metric metric);
/// "RMS distance", ...: titles of plots, without the unit.
[[nodiscard]] std::string_view MetricTitle(Metric metric);
/// Inverse of MetricName; empty if there is no such metric.
[[nodiscard]] std::optional<Metric> MetricFromName(std::string_view name);

/// All metrics of one field, indexed by Metric.
using MetricValues = std::array<double, kMetricCount>;

/// Metrics of a field of squared float32 distances (n >= 1, finite, >= 0): distances are the
/// float32 roots. Sums run in double, in 16 lanes (lane l takes the values i with i mod 16 = l, in
/// index order) that are added in order at the end; the same bits on every instruction set. Always
/// min <= geometric mean <= mean <= RMS <= max.
/// MeasureSquaredDistances (measure_distances.h) does the same with reused memory and a sketch.
/// Source: definitions of the predecessor (reference c7), geometric mean through logarithms.
[[nodiscard]] MetricValues ComputeMetrics(std::span<const float> squared_distances);

/// Metrics of any non-negative distances (n >= 1), as ComputeMetrics computes them: for distances
/// in float32, the same bits.
[[nodiscard]] MetricValues MetricsOfDistances(std::span<const double> distances);

}  // namespace cohort
