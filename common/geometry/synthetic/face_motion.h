#pragma once

#include <Eigen/Core>

#include "common/geometry/synthetic/face_layout.h"
#include "common/geometry/synthetic/face_parameters.h"

namespace cohort {

/// Where an expression moves a point of the neutral face: the displacement in mm.
///
/// @param p  a point of the neutral face.
[[nodiscard]] Eigen::Vector3d ExpressionMotion(const FaceExpression& expression,
                                               const FaceLayout& layout,
                                               const Eigen::Vector3d& p);

}  // namespace cohort
