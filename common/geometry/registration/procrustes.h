#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/mesh/landmark_set.h"

namespace cohort {

/// What becomes of the sizes of the landmark sets.
enum class ProcrustesSize {
  kKept,        ///< Form: size counts; results are in mesh units.
  kNormalized,  ///< Shape: each set is brought to centroid size 1; distances have no unit.
};

struct ProcrustesOptions {
  ProcrustesSize size = ProcrustesSize::kNormalized;
  /// Stop when the consensus moved by no more than this between two passes, as a share of its
  /// centroid size: sqrt(sum |new - old|^2) <= tolerance * size. Not for kFidentis.
  double tolerance = 1e-10;
  int max_iterations = 100;  ///< >= 1; passes over all sets.
  /// Predecessor's defect-for-defect rules; see AnalyzeProcrustes.
  enum class Variant { kExact, kFidentis } variant = Variant::kExact;
  double fidentis_threshold = 0.3;  ///< Only for kFidentis: its stop rule.
  [[nodiscard]] absl::Status Validate() const;
};

/// Generalised Procrustes analysis of N sets over their k common landmarks.
struct ProcrustesAnalysis {
  std::vector<std::string> names;  ///< k common landmarks, bytewise order.
  Eigen::Matrix3Xd consensus;      ///< 3 x k, centred (kExact), centroid size 1 if normalised.
  std::vector<Eigen::Matrix3Xd> aligned;  ///< N configurations, 3 x k each, as superimposed.
  Eigen::VectorXd centroid_sizes;         ///< N, of the sets as given, mesh units.
  Eigen::VectorXd distances_to_mean;      ///< N, sqrt(sum |aligned - consensus|^2).
  Eigen::MatrixXd distances;              ///< N x N, symmetric, diagonal 0.
  int iterations = 0;                     ///< Passes made.
  bool converged = false;                 ///< The stop rule held before max_iterations.
};

/// Superimposes landmark sets: translation, proper rotation and, if sizes are normalised, scale.
///
/// Each set is centred (and brought to centroid size sqrt(sum |x - mean|^2) = 1); it is rotated
/// onto the consensus, the consensus becomes the mean of the sets (of size 1 again), and so on
/// until it rests. It starts from the set with the smallest sum of squared distances to the others
/// (the first of equal ones), so that neither the order of the sets nor an unusual first one
/// matters. The consensus is turned as that set lies in its file. `distances`: each pair with its
/// own best rotation, d = min |a - R b| (of normalised sets: the partial Procrustes distance).
///
/// kFidentis, for comparison with old studies: sets are brought to centroid size 200 but not
/// centred (a set keeps its place, multiplied); rotations are about the origin and may reflect; the
/// first set is the first mean; the end is when successive means are within `fidentis_threshold`
/// (or grow apart). All distances are those of the superimposed sets, without another rotation,
/// and divided by 200 if sizes are normalised.
/// @return kInvalidArgument for bad options, no set, or fewer than 3 common landmarks;
///         kFailedPrecondition if the landmarks of a set coincide.
/// Source: Gower 1975; Rohlf, Slice 1990; predecessor c9 for kFidentis (here in double).
[[nodiscard]] absl::StatusOr<ProcrustesAnalysis> AnalyzeProcrustes(
    std::span<const LandmarkSet> sets, const ProcrustesOptions& options);

}  // namespace cohort
