#pragma once

#include <cstdint>
#include <vector>

#include <absl/status/statusor.h>

#include "client/job_frame.h"
#include "client/probe.h"
#include "common/analysis/metric_matrix.h"
#include "common/geometry/comparison/corresponded_rms.h"

namespace cohort {

/// The signatures (pairs/signature.h) of a job's active meshes: which of many are worth an exact
/// comparison.
class Signatures {
 public:
  /// @return kNotFound if the job kept none or not of all its meshes; else as JobFrame::Load.
  [[nodiscard]] static absl::StatusOr<Signatures> Load(const JobFrame& frame);

  /// The active meshes nearest to the probe by signature, nearest first, ties by index.
  /// @return kNotFound, kDataLoss if the reference is gone or damaged.
  [[nodiscard]] absl::StatusOr<std::vector<int32_t>> Nearest(const JobFrame& frame,
                                                             const Probe& probe,
                                                             int64_t count) const;

  /// How well `count` candidates serve: of the `top` nearest meshes by `exact`, the share that is
  /// among the `count` nearest by signature. The mean over `probes` active meshes, spread evenly,
  /// each looked for among all others.
  /// @param exact  one value per pair, of the active meshes in the order of Active(). NaN: not
  /// near.
  [[nodiscard]] double Recall(const Eigen::Ref<const RowMajorMatrix>& exact,
                              int64_t top,
                              int64_t count,
                              int64_t probes) const;

 private:
  explicit Signatures(int64_t points) : fields_(points) {}
  /// Places in `meshes_`, the nearest first.
  [[nodiscard]] std::vector<int64_t> Order(const DisplacementFields& one) const;

  std::vector<int32_t> meshes_;  ///< Active(), as they are in fields_.
  DisplacementFields fields_;
};

}  // namespace cohort
