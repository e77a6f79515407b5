#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Where a surface lies and how it is turned. Weighted by area (a point cloud: by vertex), so that
/// it hardly depends on how densely the surface is triangulated. Internal to registration.
struct PrincipalFrame {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();    ///< Mesh units.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();    ///< Columns; det = +1, signs arbitrary.
  Eigen::Vector3d deviations = Eigen::Vector3d::Zero();  ///< RMS along each axis, ascending.
};

/// A mesh as an area: its frame, and points spread over it. Lives no longer than the mesh.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const TriangleMesh& mesh);

  [[nodiscard]] PrincipalFrame Frame() const;

  /// `count` points spread over the surface by area, 3 x count (a point cloud: by vertex; all
  /// vertices if there are no more). They depend on the order of the faces but not on the pose: the
  /// same mesh moved gives the same points moved.
  [[nodiscard]] Eigen::Matrix3Xd Sample(Eigen::Index count) const;

 private:
  [[nodiscard]] bool HasArea() const { return total_area_ > 0; }

  const TriangleMesh& mesh_;
  std::vector<double> areas_;  ///< Of the faces.
  double total_area_ = 0;
};

}  // namespace cohort
