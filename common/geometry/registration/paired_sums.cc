#include "common/geometry/registration/paired_sums.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace cohort {
namespace {

/// Horn's symmetric 4 x 4 matrix N of the cross-covariance S; quaternion order w, x, y, z.
Eigen::Matrix4d HornMatrix(const Eigen::Matrix3d& S) {
  const Eigen::Vector3d delta(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  Eigen::Matrix4d N;
  N(0, 0) = S.trace();
  N.block<1, 3>(0, 1) = delta.transpose();
  N.block<3, 1>(1, 0) = delta;
  N.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  return N;
}

}  // namespace

PairedSums::PairedSums(const PairSums& sums)
    : count_(sums.count),
      sum_a_(sums.a),
      sum_b_(sums.b),
      sum_ab_(sums.ba.transpose()),
      sum_aa_(sums.aa),
      sum_bb_(sums.bb) {}

void PairedSums::Add(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  ++count_;
  sum_a_ += a;
  sum_b_ += b;
  sum_ab_ += a * b.transpose();
  sum_aa_ += a.squaredNorm();
  sum_bb_ += b.squaredNorm();
}

absl::StatusOr<Similarity> PairedSums::Fit(const ScaleRule& rule) const {
  if (count_ == 0) {
    return absl::FailedPreconditionError("similarity fit: no pairs");
  }
  if (rule.mode == ScaleMode::kFromX) {
    return absl::InvalidArgumentError("similarity fit: the scale \"from-x\" is not one of ours");
  }
  const Eigen::Vector3d mean_a = sum_a_ / static_cast<double>(count_);
  const Eigen::Vector3d mean_b = sum_b_ / static_cast<double>(count_);
  const Eigen::Matrix3d S = sum_ab_ - sum_a_ * mean_b.transpose();
  const double spread = sum_aa_ - sum_a_.dot(mean_a);
  // What is left of points that coincide away from the origin is rounding.
  if (!(spread > 1e-14 * sum_aa_)) {
    return absl::FailedPreconditionError("similarity fit: the source points coincide");
  }

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(HornMatrix(S));
  const Eigen::Vector4d q = eigen.eigenvectors().col(3);  // the largest eigenvalue comes last
  const Eigen::Matrix3d R =
      Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();

  Similarity T;
  T.rotation = R;
  T.scale = rule.fixed;
  if (rule.mode == ScaleMode::kFree) {
    T.scale = (R * S).trace() / spread;  // sum b'.(R a') = trace(R S): Horn 1987, section 2.D.
  } else if (rule.mode == ScaleMode::kSymmetric) {
    const double target_spread = sum_bb_ - sum_b_.dot(mean_b);
    T.scale = std::sqrt(std::max(0.0, target_spread) / spread);  // Horn 1987, section 2.E.
  }
  if (rule.mode != ScaleMode::kOff) {
    T.scale = std::clamp(T.scale, rule.least, rule.greatest);
  }
  if (!(T.scale > 0)) {
    return absl::FailedPreconditionError("similarity fit: the scale is not positive");
  }
  T.translation = mean_b - T.scale * (R * mean_a);
  return T;
}

}  // namespace cohort
