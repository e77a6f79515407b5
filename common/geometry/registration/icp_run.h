#pragma once

#include <limits>
#include <memory>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/registration/pair_finder.h"
#include "common/geometry/registration/paired_sums.h"
#include "common/geometry/registration/scaling_icp.h"

namespace cohort {

/// How far the moved source is from the target.
struct Distances {
  double error = std::numeric_limits<double>::infinity();  ///< That never rises.
  double mean = 0;
  double rms = 0;
};

/// One alignment while it runs. The similarities in here map the centred source to the centred
/// target. Internal to registration.
class IcpRun {
 public:
  IcpRun(const IcpMesh& source,
         const IcpMesh& target,
         const IcpOptions& options,
         PacketSearch& search);

  /// Pairs the vertices of the source at `pose`; the pairs stay until the next call.
  absl::StatusOr<Distances> LookUp(const Similarity& pose);

  /// Best similarity to what was paired last, from the untouched source.
  [[nodiscard]] absl::StatusOr<Similarity> Fit(const ScaleRule& rule) const {
    return PairedSums(sums_).Fit(rule);
  }

  /// RMS distance of the source from its centroid.
  [[nodiscard]] double Radius() const;
  [[nodiscard]] int Passes() const { return passes_; }

  /// Residuals of the pairs found last, shares.
  void Report(const Similarity& pose, Alignment& alignment) const;

 private:
  /// Marks the pairs that count.
  void RejectPairs(const Similarity& pose);
  /// Squared error that a pair too far apart is charged with: what one at the limit costs, so that
  /// none is dropped for gain.
  [[nodiscard]] double SquaredLimit(const Similarity& pose) const;
  /// What squared distances are divided by.
  [[nodiscard]] double ErrorUnit(const Similarity& pose) const;
  [[nodiscard]] float LargestSquaredDistance(const Similarity& pose);
  [[nodiscard]] Distances Measure(const Similarity& pose) const;

  const IcpMesh& source_;
  const IcpMesh& target_;
  const IcpOptions& options_;
  const bool counts_all_;
  std::unique_ptr<PairFinder> pairs_;
  AlignedArray<uint16_t> kept_;
  PairSums sums_;
  std::vector<float> sorted_;
  int passes_ = 0;
};

}  // namespace cohort
