#include "common/geometry/registration/anderson.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/QR>

namespace cohort {
namespace {

constexpr size_t kWindow = 5;

}  // namespace

AndersonMixing::Vector7 AndersonMixing::ToVector(const Similarity& T) const {
  Eigen::Quaterniond turn(Eigen::Matrix3d(T.rotation * origin_.rotation.transpose()));
  if (turn.w() < 0) {
    turn.coeffs() = -turn.coeffs();
  }
  Vector7 x;
  x.head<3>() = 2 * radius_ * turn.vec();
  x.segment<3>(3) = T.translation;
  x(6) = radius_ * (T.scale / origin_.scale);
  return x;
}

bool AndersonMixing::FromVector(const Vector7& x, Similarity& T) const {
  const Eigen::Vector3d turn = x.head<3>() / (2 * radius_);
  const double squared = turn.squaredNorm();
  const double scale = origin_.scale * (x(6) / radius_);
  if (!(squared < 1) || !(scale > 0) || !x.allFinite()) {
    return false;
  }
  const Eigen::Quaterniond q(std::sqrt(1 - squared), turn.x(), turn.y(), turn.z());
  T.rotation = q.toRotationMatrix() * origin_.rotation;
  T.translation = x.segment<3>(3);
  T.scale = scale;
  return true;
}

Similarity AndersonMixing::Next(const Similarity& pose, const Similarity& step) {
  const Vector7 target = ToVector(step);
  history_.push_back({.step = target, .residual = target - ToVector(pose)});
  if (history_.size() > kWindow + 1) {
    history_.pop_front();
  }
  const auto count = static_cast<Eigen::Index>(history_.size()) - 1;
  if (count == 0) {
    return step;
  }
  Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::ColMajor, 7, kWindow> residual_changes(7, count);
  Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::ColMajor, 7, kWindow> step_changes(7, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Entry& older = history_[static_cast<size_t>(i)];
    const Entry& newer = history_[static_cast<size_t>(i) + 1];
    residual_changes.col(i) = newer.residual - older.residual;
    step_changes.col(i) = newer.step - older.step;
  }
  const Eigen::VectorXd weights =
      residual_changes.colPivHouseholderQr().solve(history_.back().residual);
  Similarity next = step;
  return FromVector(target - step_changes * weights, next) ? next : step;
}

}  // namespace cohort
