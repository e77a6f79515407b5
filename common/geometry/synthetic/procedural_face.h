#pragma once

#include <Eigen/Core>

#include "common/geometry/synthetic/face_features.h"
#include "common/geometry/synthetic/face_layout.h"
#include "common/geometry/synthetic/face_parameters.h"
#include "common/geometry/synthetic/head_shape.h"

namespace cohort {

/// A human face as a smooth parametric surface: a mask from hairline to under the chin and from
/// temple to temple, eyes closed. It looks along +z, +y is up, in mm, about 140 wide.
///
/// (u, v) has the same anatomical meaning on every face, so points of equal (u, v) correspond.
/// Const calls may run together. Source: ours.
class ProceduralFace {
 public:
  explicit ProceduralFace(const FaceParameters& parameters);

  /// @param u  -105..105, positive is the face's left (+x).
  /// @param v  -125..105, from under the chin to the hairline. Both are close to mm of arc.
  [[nodiscard]] Eigen::Vector3d Point(double u, double v) const;

 private:
  [[nodiscard]] Eigen::Vector3d Individual(const Eigen::Vector3d& p) const;

  FaceParameters parameters_;
  FaceLayout layout_;
  HeadShape head_;
  FaceFeatures features_;
};

}  // namespace cohort
