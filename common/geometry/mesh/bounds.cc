#include "common/geometry/mesh/bounds.h"

#include <cassert>
#include <cmath>

namespace cohort {

Bounds BoundsOf(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  assert(points.cols() >= 1);
  return {.low = points.rowwise().minCoeff(), .high = points.rowwise().maxCoeff()};
}

// The sums below are plain loops on purpose: Eigen's reductions change their order with the
// instruction set, and the same mesh must give the same bytes everywhere.
Eigen::Vector3d CentroidOf(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  assert(points.cols() >= 1);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    sum += points.col(i);
  }
  return sum / static_cast<double>(points.cols());
}

double RmsRadius(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  const Eigen::Vector3d centroid = CentroidOf(points);
  double sum = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d offset = points.col(i) - centroid;
    sum += offset.x() * offset.x() + offset.y() * offset.y() + offset.z() * offset.z();
  }
  return std::sqrt(sum / static_cast<double>(points.cols()));
}

}  // namespace cohort
