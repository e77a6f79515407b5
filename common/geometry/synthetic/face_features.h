#pragma once

#include <Eigen/Core>

#include "common/geometry/synthetic/face_layout.h"
#include "common/geometry/synthetic/face_parameters.h"

namespace cohort {

/// Eyes, nose and mouth, put on the head as heights along z. Const calls may run together.
class FaceFeatures {
 public:
  FaceFeatures(const FaceIdentity& identity, const FaceLayout& layout)
      : identity_(identity), layout_(layout) {}

  /// @param head  a point of the head without features.
  /// @return z of the face at that x and y.
  [[nodiscard]] double Height(const Eigen::Vector3d& head) const;

 private:
  [[nodiscard]] double WithEyes(double side, double y, double z) const;
  [[nodiscard]] double LidRelief(double across, double up) const;
  [[nodiscard]] double WithNose(double x, double y, double z) const;
  [[nodiscard]] double RidgeHeight(double y) const;
  [[nodiscard]] double WithMouth(double x, double y, double z) const;
  [[nodiscard]] double LipRelief(double side, double up) const;

  FaceIdentity identity_;
  FaceLayout layout_;
};

}  // namespace cohort
