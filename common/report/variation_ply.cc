#include "common/report/variation_ply.h"

#include <algorithm>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/io/write_mesh.h"
#include "common/report/color_map.h"

namespace cohort {
namespace {

constexpr double kLowShare = 0.02;
constexpr double kHighShare = 0.98;

std::vector<double> ValuesOf(const VariationSummary& summary, Metric metric) {
  std::vector<double> values;
  values.reserve(summary.values.size());
  for (const MetricValues& vertex : summary.values) {
    values.push_back(vertex[static_cast<size_t>(metric)]);
  }
  return values;
}

VertexScalar Scalar(const VariationSummary& summary, Metric metric) {
  VertexScalar scalar;
  scalar.name = MetricName(metric);
  std::replace(scalar.name.begin(), scalar.name.end(), '-', '_');
  for (const double value : ValuesOf(summary, metric)) {
    scalar.values.push_back(static_cast<float>(value));
  }
  return scalar;
}

std::vector<VertexScalar> Scalars(const VariationSummary& summary) {
  std::vector<VertexScalar> scalars;
  scalars.reserve(kMetricCount);
  for (const Metric metric : kAllMetrics) scalars.push_back(Scalar(summary, metric));
  return scalars;
}

absl::Status CheckSizes(const TriangleMesh& mean_shape, const VariationSummary& summary) {
  if (std::ssize(summary.values) == mean_shape.VertexCount()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "variation: a summary of " + std::to_string(summary.values.size()) +
      " vertices for a mean shape of " + std::to_string(mean_shape.VertexCount()));
}

}  // namespace

ValueRange VariationColorRange(const VariationSummary& summary) {
  return QuantileRange(ValuesOf(summary, Metric::kRms), kLowShare, kHighShare);
}

absl::StatusOr<std::string> VariationPly(const TriangleMesh& mean_shape,
                                         const VariationSummary& summary) {
  COHORT_RETURN_IF_ERROR(CheckSizes(mean_shape, summary));
  const std::vector<VertexScalar> scalars = Scalars(summary);
  const ValueRange range = VariationColorRange(summary);
  std::vector<Rgb> colors;
  colors.reserve(summary.values.size());
  for (const double value : ValuesOf(summary, Metric::kRms)) {
    colors.push_back(MapColor(range.Position(value)));
  }
  return WritePly(mean_shape, scalars, colors);
}

absl::StatusOr<std::string> VariationVtk(const TriangleMesh& mean_shape,
                                         const VariationSummary& summary) {
  COHORT_RETURN_IF_ERROR(CheckSizes(mean_shape, summary));
  return WriteVtk(mean_shape, Scalars(summary));
}

std::string MeanShapePly(const TriangleMesh& mean_shape) {
  return WritePly(mean_shape);
}

}  // namespace cohort
