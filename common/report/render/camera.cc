#include "common/report/render/camera.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "common/geometry/mesh/bounds.h"

namespace cohort {
namespace {

// A closed surface has a mean normal of length 0, a half sphere one of 0.5.
constexpr double kOpenShare = 0.2;
constexpr double kCosine = 0.8;
constexpr double kSine = 0.6;
constexpr double kMargin = 1.04;
constexpr double kThinnest = 1e-3;  // What is seen edge on is given some width, to divide by.

// Sums of the faces' normals times their areas, and of the areas.
struct NormalSum {
  Eigen::Vector3d normals = Eigen::Vector3d::Zero();
  double areas = 0;
};

NormalSum SumNormals(const TriangleMesh& mesh) {
  NormalSum sum;
  for (int64_t face = 0; face < mesh.FaceCount(); ++face) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, face));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.faces(1, face));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.faces(2, face));
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    sum.normals += cross;
    sum.areas += cross.norm();
  }
  return sum;
}

// Of the mesh about its own upward axis: the share of its own left that comes into the picture.
double TurnOf(View view) {
  switch (view) {
    case View::kFront:
      return 0;
    case View::kLeftThreeQuarter:
      return kSine;
    case View::kRightThreeQuarter:
      return -kSine;
  }
  return 0;
}

}  // namespace

Facing FacingOf(const TriangleMesh& mesh) {
  const NormalSum sum = SumNormals(mesh);
  if (sum.areas <= 0 || sum.normals.norm() < kOpenShare * sum.areas) return {};
  Eigen::Index axis = 0;
  sum.normals.cwiseAbs().maxCoeff(&axis);
  Facing facing;
  facing.front = Eigen::Vector3d::Unit(axis) * (sum.normals(axis) < 0 ? -1.0 : 1.0);
  facing.up = axis == 2 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  return facing;
}

Eigen::Matrix3Xd Camera::Project(const Eigen::Ref<const Eigen::Matrix3Xd>& points) const {
  Eigen::Matrix3Xd seen = R_camera_mesh * (points.colwise() - center);
  seen.row(0) /= half_width;
  seen.row(1) /= half_height;
  return seen;
}

Camera FitCamera(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                 const Facing& facing,
                 View view) {
  const Eigen::Vector3d left = facing.up.cross(facing.front);  // Its own left: our right.
  const double turn = TurnOf(view);
  const double ahead = turn == 0 ? 1.0 : kCosine;
  // To see its left side, the viewer goes to its left.
  const Eigen::Vector3d towards = ahead * facing.front + turn * left;
  Camera camera;
  camera.R_camera_mesh.row(0) = facing.up.cross(towards);
  camera.R_camera_mesh.row(1) = facing.up;
  camera.R_camera_mesh.row(2) = towards;
  const Bounds box = BoundsOf(camera.R_camera_mesh * points);
  camera.center = camera.R_camera_mesh.transpose() * box.Center();
  const Eigen::Vector3d half = 0.5 * kMargin * (box.high - box.low);
  const double thinnest = kThinnest * half.norm();
  camera.half_width = std::max(half.x(), thinnest > 0 ? thinnest : 1);
  camera.half_height = std::max(half.y(), thinnest > 0 ? thinnest : 1);
  return camera;
}

Camera WithAspect(Camera camera, double aspect) {
  if (camera.half_width < camera.half_height * aspect) {
    camera.half_width = camera.half_height * aspect;
  } else {
    camera.half_height = camera.half_width / aspect;
  }
  return camera;
}

}  // namespace cohort
