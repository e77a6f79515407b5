#pragma once

#include <deque>

#include <Eigen/Core>

#include "common/geometry/registration/similarity.h"

namespace cohort {

/// Anderson mixing of the fixed-point iteration T -> step(T) over similarities: the next pose is
/// the combination of the last steps whose residual step(T) - T would vanish if the iteration were
/// linear. Internal to registration.
///
/// Similarities are compared as 7 lengths: twice the vector part of the quaternion since `origin`
/// times `radius`, the translation, and the scale relative to `origin` times `radius`. No function
/// of the C library is used whose last bit differs between machines.
/// Source: Walker, Ni 2011, problem (2.2); window of 5 after Pavlov et al. 2018.
class AndersonMixing {
 public:
  /// @param origin  a pose close to all that follow.
  /// @param radius  RMS distance of the source from its centroid, source units.
  AndersonMixing(const Similarity& origin, double radius) : origin_(origin), radius_(radius) {}

  /// @param pose  that the step was taken from; step: where it led.
  [[nodiscard]] Similarity Next(const Similarity& pose, const Similarity& step);
  /// Forgets the steps seen.
  void Restart() { history_.clear(); }
  [[nodiscard]] bool HasHistory() const { return history_.size() > 1; }

 private:
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  struct Entry {
    Vector7 step;
    Vector7 residual;
  };
  [[nodiscard]] Vector7 ToVector(const Similarity& T) const;
  /// @return false if no similarity has this vector.
  [[nodiscard]] bool FromVector(const Vector7& x, Similarity& T) const;

  const Similarity origin_;
  const double radius_;
  std::deque<Entry> history_;  ///< Oldest first.
};

}  // namespace cohort
