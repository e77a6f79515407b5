#include "common/pairs/kept_distances.h"

#include <cmath>
#include <limits>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/distance_codec.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/sketch_measure.h"

namespace cohort {
namespace {

constexpr PairValue kNothing = {.value = std::numeric_limits<double>::quiet_NaN(), .bound = 0};

absl::StatusOr<PairValue> MeasureOneSketch(std::string_view bytes, const MeasureSpec& spec) {
  COHORT_ASSIGN_OR_RETURN(const DistanceSketch sketch, DecodeSketch(bytes));
  const absl::StatusOr<SketchMeasure> measured = MeasureSketch(sketch, spec.ToFieldOptions());
  COHORT_RETURN_IF_ERROR(measured.status());
  return PairValue{.value = spec.ValueOf(measured->value),
                   .bound = spec.percentile ? measured->percentile_bound
                                            : measured->bounds[static_cast<size_t>(spec.metric)]};
}

}  // namespace

absl::StatusOr<PairValue> MeasurePair(std::span<const float> distances,
                                      std::span<const double> weights,
                                      const MeasureSpec& spec) {
  if (distances.empty()) {
    return kNothing;
  }
  const absl::StatusOr<FieldMeasure> measured =
      weights.empty() ? MeasureField(distances, spec.ToFieldOptions())
                      : MeasureWeightedField(distances, weights, spec.ToFieldOptions());
  if (absl::IsFailedPrecondition(measured.status())) {
    return kNothing;  // Thresholds or weights leave none.
  }
  COHORT_RETURN_IF_ERROR(measured.status());
  return PairValue{.value = spec.ValueOf(*measured), .bound = 0};
}

absl::StatusOr<PairValue> MeasureKept(const KeptField& field,
                                      Retention retention,
                                      std::span<const double> weights,
                                      const MeasureSpec& spec) {
  if (field.values == 0) {
    return kNothing;
  }
  switch (retention) {
    case Retention::kVectors: {
      COHORT_ASSIGN_OR_RETURN(const std::vector<float> distances,
                              DecodeVectors(field.bytes, field.values));
      return MeasurePair(distances, weights, spec);
    }
    case Retention::kCompact: {
      COHORT_ASSIGN_OR_RETURN(const CompactField kept, DecodeCompact(field.bytes, field.values));
      return MeasurePair(kept.distances, weights, spec);
    }
    case Retention::kSketch: {
      if (!weights.empty()) {
        return absl::FailedPreconditionError(
            "the job kept sketches, which do not know which vertex a distance is of");
      }
      return MeasureOneSketch(field.bytes, spec);
    }
    case Retention::kMetrics:
    case Retention::kAuto:
      break;
  }
  return absl::FailedPreconditionError("the job kept nothing of its distances");
}

}  // namespace cohort
