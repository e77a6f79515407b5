#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/nearest/nearest_vertex.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

struct IcpOptions {
  ScaleMode scale_mode = ScaleMode::kSymmetric;
  int max_iterations = 200;  ///< >= 1.
  /// Stop when the mean nearest-neighbour distance changed by no more than this between two
  /// successive passes (mesh units). 0: never, all iterations run.
  double tolerance = 1e-6;
  [[nodiscard]] absl::Status Validate() const;
};

/// A reference that meshes are aligned to: its vertices, centred, behind a search index.
/// Immutable after construction; const use may run together.
class IcpTarget {
 public:
  /// Builds one index.
  /// @param vertices  3 x n, n >= 1, target units.
  explicit IcpTarget(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices);

  [[nodiscard]] const NearestVertex& Index() const { return *index_; }
  /// The index holds float(vertex - Center()).
  [[nodiscard]] const Eigen::Vector3d& Center() const { return center_; }

 private:
  Eigen::Vector3d center_;
  std::unique_ptr<const NearestVertex> index_;
};

/// Similarity and how well it converged.
struct Alignment {
  Similarity T_target_source;
  int iterations = 0;      ///< Passes = look-ups / vertices.
  bool converged = false;  ///< The stop rule held before max_iterations was reached.
  /// Of the last pass: source vertices, moved by T_target_source, to the vertices of the target
  /// that were nearest before that move. No extra look-up is spent on it.
  double rms_residual = 0;
  double mean_residual = 0;
  int64_t lookups = 0;  ///< Nearest-vertex queries made.
};

/// Scaling ICP: repeat { nearest vertex of each source vertex, closed-form similarity }.
///
/// Each pass fits the absolute similarity from the untransformed source, so that no drift builds
/// up; the squared error never rises (Besl, McKay 1992) with scale off or least-squares; the
/// symmetric scale gives up that guarantee for not shrinking.
/// @param source  3 x n, n >= 3, source units.
/// @param T_target_source  the start.
/// @return kInvalidArgument for bad options or n < 3; kFailedPrecondition if the fit is impossible
///         or the scale leaves [0.1, 10] times the start (collapse).
/// Source: Besl, McKay 1992; Horn 1987; thesis section 3.2.
[[nodiscard]] absl::StatusOr<Alignment> AlignByIcp(const Eigen::Ref<const Eigen::Matrix3Xd>& source,
                                                   const IcpTarget& target,
                                                   const Similarity& T_target_source,
                                                   const IcpOptions& options);

}  // namespace cohort
