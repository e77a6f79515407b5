#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "common/geometry/synthetic/face_layout.h"
#include "common/geometry/synthetic/face_parameters.h"

namespace cohort {

/// Smooth curve through given points: cubic Hermite with finite-difference slopes, first derivative
/// continuous. Plain value, const calls may run together.
template <size_t N>
class ProfileCurve {
 public:
  ProfileCurve() = default;
  /// @param knots  increasing.
  ProfileCurve(const std::array<double, N>& knots, const std::array<double, N>& values);
  [[nodiscard]] double At(double v) const;

 private:
  std::array<double, N> knots_ = {};
  std::array<double, N> values_ = {};
  std::array<double, N> slopes_ = {};
};

/// The head without eyes, nose and mouth: a middle profile swept sideways as half ellipses, plus
/// the soft forms of brow, sockets, cheeks, jaw and chin. Const calls may run together.
class HeadShape {
 public:
  static constexpr size_t kKnots = 14;

  HeadShape(const FaceIdentity& identity, const FaceLayout& layout);

  /// @param u  along the section, mm of arc of an average head, 0 in the middle, right positive.
  /// @param v  along the middle profile, about mm, 0 near the nose tip, up positive.
  [[nodiscard]] Eigen::Vector3d Point(double u, double v) const;

 private:
  /// How far the surface at (x, y) stands out of the swept profile, mm along the radius.
  [[nodiscard]] double Relief(double x, double y) const;
  [[nodiscard]] double CheekRelief(double side, double y) const;

  FaceIdentity identity_;
  FaceLayout layout_;
  ProfileCurve<kKnots> height_;      // y of the middle profile
  ProfileCurve<kKnots> front_;       // z of the middle profile
  ProfileCurve<kKnots> half_width_;  // of the section
  ProfileCurve<kKnots> depth_;       // of the section, front to widest
  ProfileCurve<kKnots> lift_;        // how much higher the section is at its side
};

}  // namespace cohort
