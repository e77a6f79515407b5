#pragma once

#include <span>

#include <absl/status/statusor.h>

#include "common/jobs/field_blob.h"
#include "common/pairs/measure_spec.h"

namespace cohort {

/// A number of one directed pair, and how far it can be from that of the distances themselves.
struct PairValue {
  double value = 0;  ///< NaN: no distance counts, or the thresholds leave none.
  double bound = 0;  ///< 0: exact. Of compact distances: from those as kept, which are rounded.
};

/// Measures distances.
/// @param weights  as many, in the same order; or none: all count the same.
/// @return kInvalidArgument for a bad spec or bad weights.
[[nodiscard]] absl::StatusOr<PairValue> MeasurePair(std::span<const float> distances,
                                                    std::span<const double> weights,
                                                    const MeasureSpec& spec);

/// Measures what a job has kept of a pair.
/// @param weights  in the order of the kept distances; none for a sketch, which cannot tell
/// vertices
///                 apart.
/// @return kFailedPrecondition if what was kept cannot answer: nothing, a sketch and weights; also
///         as MeasurePair and the decoders of distance_codec.h.
[[nodiscard]] absl::StatusOr<PairValue> MeasureKept(const KeptField& field,
                                                    Retention retention,
                                                    std::span<const double> weights,
                                                    const MeasureSpec& spec);

}  // namespace cohort
