#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/job_frame.h"
#include "common/analysis/metric_matrix.h"
#include "common/base/executor.h"
#include "common/pairs/measure_spec.h"

namespace cohort {

/// Where the numbers of another matrix come from.
enum class MeasureSource {
  kAuto,       ///< The cheapest of the following that can answer.
  kMetrics,    ///< The seven metrics that every job has.
  kKept,       ///< What the job kept of its distances.
  kRecompute,  ///< The distances are found once more, on this machine.
};

struct RemeasureOptions {
  MeasureSpec measure;
  MeasureSource source = MeasureSource::kAuto;
  std::optional<std::vector<double>> region;  ///< Weight per vertex of the mean shape.
};

/// Another matrix of a finished job.
struct Remeasured {
  RowMajorMatrix directed;                         ///< Over all meshes of the job.
  MeasureSource source = MeasureSource::kMetrics;  ///< Not kAuto.
  Retention retention = Retention::kMetrics;       ///< Of kKept.
  double largest_bound = 0;  ///< No value is farther than this from that of the distances.
};

/// Measures all pairs of a job in another way. Nothing of the job changes. Deterministic: the same
/// bytes with any executor.
/// @return kFailedPrecondition if the source asked for cannot answer, saying why and what would;
///         kInvalidArgument for the measure.
[[nodiscard]] absl::StatusOr<Remeasured> Remeasure(Session& session,
                                                   const JobFrame& frame,
                                                   const RemeasureOptions& options,
                                                   Executor& executor);

/// "metrics", "kept", "recompute", "auto".
[[nodiscard]] std::string MeasureSourceName(MeasureSource source);

}  // namespace cohort
