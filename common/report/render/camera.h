#pragma once

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Which way a shape looks, in its own frame: unit vectors at right angles.
struct Facing {
  Eigen::Vector3d front = Eigen::Vector3d::UnitZ();  ///< Out of the face.
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
};

/// The axis nearest to the mean normal of an open surface is its front; up is +y, or +z where the
/// front is along x or y (as in the frames of tomographs). A closed surface, whose normals cancel,
/// and a point cloud look along +z.
[[nodiscard]] Facing FacingOf(const TriangleMesh& mesh);

/// From where a shape is seen. The three-quarter views are 36.87 degrees (cos 0.8, sin 0.6: exact)
/// to the side.
enum class View {
  kFront,
  kLeftThreeQuarter,   ///< The face turned so that its own left side shows.
  kRightThreeQuarter,  ///< The face turned so that its own right side shows.
};

/// An orthographic camera.
struct Camera {
  /// Rows: to the right, up and towards the viewer, in the frame of the mesh.
  Eigen::Matrix3d R_camera_mesh = Eigen::Matrix3d::Identity();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< Middle of the picture, mesh frame.
  double half_width = 1;   ///< From the middle to the left and right edge, mesh units, > 0.
  double half_height = 1;  ///< To the upper and lower edge.

  /// 3 x n in the mesh's frame -> x right, y up (both -1..1 inside the picture), z towards the
  /// viewer (mesh units).
  [[nodiscard]] Eigen::Matrix3Xd Project(const Eigen::Ref<const Eigen::Matrix3Xd>& points) const;
};

/// A camera that shows all points with a margin of 4 %, as wide and high as they are.
/// @param points  3 x n, n >= 1.
[[nodiscard]] Camera FitCamera(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                               const Facing& facing,
                               View view);

/// The camera made wider or higher for pictures of width / height `aspect`.
[[nodiscard]] Camera WithAspect(Camera camera, double aspect);

}  // namespace cohort
