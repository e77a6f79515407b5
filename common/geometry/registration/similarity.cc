#include "common/geometry/registration/similarity.h"

#include <string>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/registration/paired_sums.h"

namespace cohort {

Eigen::Matrix3Xd Similarity::Apply(const Eigen::Ref<const Eigen::Matrix3Xd>& points) const {
  Eigen::Matrix3Xd moved(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    moved.col(i) = ApplyToPoint(points.col(i));
  }
  return moved;
}

Eigen::Vector3d Similarity::ApplyToPoint(const Eigen::Vector3d& point) const {
  return scale * (rotation * point) + translation;
}

Similarity Similarity::Inverse() const {
  Similarity inverse;
  inverse.scale = 1.0 / scale;
  inverse.rotation = rotation.transpose();
  inverse.translation = -inverse.scale * (inverse.rotation * translation);
  return inverse;
}

Similarity operator*(const Similarity& T_c_b, const Similarity& T_b_a) {
  Similarity T_c_a;
  T_c_a.scale = T_c_b.scale * T_b_a.scale;
  T_c_a.rotation = T_c_b.rotation * T_b_a.rotation;
  T_c_a.translation = T_c_b.ApplyToPoint(T_b_a.translation);
  return T_c_a;
}

Eigen::Matrix4d Similarity::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = scale * rotation;
  matrix.topRightCorner<3, 1>() = translation;
  return matrix;
}

absl::StatusOr<Similarity> FitSimilarity(const Eigen::Ref<const Eigen::Matrix3Xd>& source,
                                         const Eigen::Ref<const Eigen::Matrix3Xd>& target,
                                         ScaleMode scale_mode) {
  if (source.cols() != target.cols() || source.cols() < 3) {
    return absl::InvalidArgumentError(absl::StrCat("similarity fit: needs >= 3 paired points, got ",
                                                   source.cols(), " and ", target.cols()));
  }
  const Eigen::Vector3d source_mean = CentroidOf(source);
  const Eigen::Vector3d target_mean = CentroidOf(target);
  // The centroid of coinciding points is off by a rounding; relative to where they lie, no extent.
  const double extent = (source.colwise() - source_mean).colwise().squaredNorm().maxCoeff();
  if (extent <= 1e-28 * source.colwise().squaredNorm().maxCoeff()) {
    return absl::FailedPreconditionError("similarity fit: the source points coincide");
  }

  PairedSums sums;
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    sums.Add(source.col(i) - source_mean, target.col(i) - target_mean);
  }
  COHORT_ASSIGN_OR_RETURN(Similarity T, sums.Fit(scale_mode));
  T.translation += target_mean - T.scale * (T.rotation * source_mean);
  return T;
}

}  // namespace cohort
