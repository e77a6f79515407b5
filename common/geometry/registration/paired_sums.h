#pragma once

#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// How the scale of a fit is found.
struct ScaleRule {
  ScaleMode mode = ScaleMode::kOff;
  double fixed = 1;  ///< kOff: the scale.
  /// Other modes: the best scale in this range. The error has one minimum over the scale, so that
  /// the bound next to it is the best one inside.
  double least = 0;
  double greatest = std::numeric_limits<double>::infinity();
};

/// Sums over paired points from which the least-squares similarity follows: one pass, no
/// temporaries, always added in the caller's order. Points should lie about the origin, else digits
/// cancel. Internal to registration.
class PairedSums {
 public:
  PairedSums() = default;
  explicit PairedSums(const PairSums& sums);
  void Add(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

  /// Similarity that minimises sum |s R a + t - b|^2; see FitSimilarity.
  /// @return kFailedPrecondition if the points a coincide or the scale is not positive.
  [[nodiscard]] absl::StatusOr<Similarity> Fit(const ScaleRule& rule) const;
  [[nodiscard]] absl::StatusOr<Similarity> Fit(ScaleMode mode) const {
    return Fit(ScaleRule{.mode = mode});
  }

 private:
  int64_t count_ = 0;
  Eigen::Vector3d sum_a_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum_b_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d sum_ab_ = Eigen::Matrix3d::Zero();  ///< a b^T
  double sum_aa_ = 0;                                 ///< a . a
  double sum_bb_ = 0;                                 ///< b . b
};

}  // namespace cohort
