#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/nearest/nearest_vertex.h"
#include "common/geometry/registration/similarity.h"

namespace cohort {

enum class FidentisScale {
  kOff,
  /// sum c'_x (R a')_x / sum (R a')_x^2: of the x coordinates only, as the predecessor has it where
  /// the thesis (eq. 3.9) takes the whole dot product.
  kFromX,
};

struct FidentisIcpOptions {
  FidentisScale scale = FidentisScale::kOff;
  int max_iterations = 10;  ///< >= 1. Up to max_iterations + 1 steps are made, never fewer than 2.
  /// >= 0, mesh units. Stop when the mean distances found before the last two steps differ by no
  /// more. 0 stops at equal floats.
  float tolerance = 0.05F;
  [[nodiscard]] absl::Status Validate() const;
};

/// One step of the predecessor's ICP: v' = scale * (q v q*) + translation, about the origin.
struct FidentisStep {
  float mean_distance = 0;  ///< Of the vertices to their nearest ones, before the step; mesh units.
  Eigen::Vector3f translation = Eigen::Vector3f::Zero();  ///< Mesh units.
  float scale = 1;                                        ///< Unitless.
  Eigen::Vector4f rotation = Eigen::Vector4f::UnitW();    ///< q as x, y, z, w; w >= 0.
};

struct FidentisAlignment {
  Eigen::Matrix3Xf moved;           ///< 3 x n: what the next round and the comparison go on from.
  std::vector<FidentisStep> steps;  ///< In order; their number is the predecessor's "iterations".
  bool converged = false;           ///< The stop rule held; false: all steps were used.
  int64_t lookups = 0;              ///< Nearest-vertex queries: n for each step.
  /// All steps in double. For reports: applied to the source it differs from `moved` by what the
  /// steps rounded (some 1e-4 mm on faces), and single nearest vertices may differ with it.
  Similarity T_target_source;
};

/// Middle of the box around the vertices, as floats: (highest + lowest) / 2 for each axis.
/// @param vertices  3 x n, n >= 1, mesh units.
[[nodiscard]] Eigen::Vector3f FidentisCenter(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices);

/// The vertices as floats about FidentisCenter: what the predecessor makes of a mesh it loads.
[[nodiscard]] Eigen::Matrix3Xf FidentisCentered(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices);

/// ICP as in the predecessor, FIDENTIS Analyst of 2016, with its numbers and its defects: float32
/// sums in vertex order, scale from x alone, rotation and scale about the origin although the
/// translation is the mean step to the nearest vertices from before them, one step more than asked.
///
/// Cumulative: the next alignment of the same mesh starts from `moved`. Deterministic; the matrices
/// and mean shapes of the golden data come out equal to the last bit.
/// @param source  3 x n, n >= 3, mesh units; centred by FidentisCentered, or `moved` of before.
/// @param target  the mesh or mean shape to move to, about the origin too.
/// @return kInvalidArgument for bad options or n < 3; kFailedPrecondition if a step is not finite
///         or its scale not positive, where the predecessor went on with what it had.
/// Source: reference c3 and (f); thesis eq. 3.3-3.9.
[[nodiscard]] absl::StatusOr<FidentisAlignment> AlignByFidentisIcp(
    const Eigen::Ref<const Eigen::Matrix3Xf>& source,
    const NearestVertex& target,
    const FidentisIcpOptions& options);

}  // namespace cohort
