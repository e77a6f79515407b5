#include "common/report/render/variation_picture.h"

#include <vector>

#include "common/report/render/shape_picture.h"
#include "common/report/variation_ply.h"

namespace cohort {

absl::StatusOr<std::string> VariationPng(const TriangleMesh& shape,
                                         const VariationSummary& summary) {
  std::vector<double> values;
  values.reserve(summary.values.size());
  for (const MetricValues& vertex : summary.values) {
    values.push_back(vertex[static_cast<size_t>(Metric::kRms)]);
  }
  const ValueRange range = VariationColorRange(summary);
  const ShapeValues shown{.values = values,
                          .scale = {.low = range.low, .high = range.high},
                          .title = "RMS distance",
                          .unit = "mm"};
  return ShapeViewsPng(shape, shown, {});
}

}  // namespace cohort
