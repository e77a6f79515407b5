#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/landmark_set.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

/// A similarity from landmarks and how well it fits.
struct LandmarkFit {
  Similarity T_target_source;
  std::vector<std::string> names;  ///< k landmarks used, those of both sets, in bytewise order.
  Eigen::VectorXd residuals;       ///< k, |T_target_source(source) - target|, target units.
  double rms = 0;                  ///< sqrt(mean of the squared residuals), target units.
};

/// Procrustes fit of one landmark set onto another over the names that both have.
///
/// @return kInvalidArgument if fewer than three names are common (the message lists those that one
///         set lacks); kFailedPrecondition if the common landmarks of a set lie on one line (their
///         deviation from it below 1e-3 of that along it: the turn about the line is then noise),
///         or FitSimilarity's.
/// Source: FitSimilarity.
[[nodiscard]] absl::StatusOr<LandmarkFit> FitLandmarks(const LandmarkSet& source,
                                                       const LandmarkSet& target,
                                                       ScaleMode scale_mode);

}  // namespace cohort
