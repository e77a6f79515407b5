#include "common/geometry/registration/surface_sample.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace cohort {
namespace {

/// Calls visit(point, weight) for points with weights that have the surface's centroid and second
/// moments: the middles of the edges, each with the face's area, are exact up to the second.
template <typename Visit>
void ForEachMassPoint(const TriangleMesh& mesh, const std::vector<double>& areas, Visit visit) {
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.faces(1, f));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.faces(2, f));
    const double area = areas[static_cast<size_t>(f)];
    visit(Eigen::Vector3d(0.5 * (a + b)), area);
    visit(Eigen::Vector3d(0.5 * (b + c)), area);
    visit(Eigen::Vector3d(0.5 * (c + a)), area);
  }
}

Eigen::Matrix3Xd SampleVertices(const TriangleMesh& mesh, Eigen::Index count) {
  const Eigen::Index n = mesh.vertices.cols();
  count = std::min(count, n);
  Eigen::Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    points.col(i) = mesh.vertices.col(i * n / count);
  }
  return points;
}

}  // namespace

SurfaceSampler::SurfaceSampler(const TriangleMesh& mesh)
    : mesh_(mesh), areas_(static_cast<size_t>(mesh.FaceCount())) {
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d ab = mesh.vertices.col(mesh.faces(1, f)) - a;
    const Eigen::Vector3d ac = mesh.vertices.col(mesh.faces(2, f)) - a;
    areas_[static_cast<size_t>(f)] = 0.5 * ab.cross(ac).norm();
    total_area_ += areas_[static_cast<size_t>(f)];
  }
}

PrincipalFrame SurfaceSampler::Frame() const {
  const auto for_each = [this](auto visit) {
    if (HasArea()) {
      ForEachMassPoint(mesh_, areas_, visit);
      return;
    }
    for (const auto& vertex : mesh_.vertices.colwise()) {
      visit(Eigen::Vector3d(vertex), 1.0);
    }
  };
  const double total = HasArea() ? 3 * total_area_ : static_cast<double>(mesh_.VertexCount());
  PrincipalFrame frame;
  for_each([&](const Eigen::Vector3d& point, double weight) { frame.centroid += weight * point; });
  frame.centroid /= total;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for_each([&](const Eigen::Vector3d& point, double weight) {
    const Eigen::Vector3d d = point - frame.centroid;
    covariance += weight * (d * d.transpose());
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance / total);
  frame.axes = eigen.eigenvectors();
  if (frame.axes.determinant() < 0) {
    frame.axes.col(2) = -frame.axes.col(2);
  }
  frame.deviations = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return frame;
}

Eigen::Matrix3Xd SurfaceSampler::Sample(Eigen::Index count) const {
  if (!HasArea()) {
    return SampleVertices(mesh_, count);
  }
  // Equal steps of area along the list of faces; inside a face the R2 sequence (Roberts 2018),
  // folded from the unit square into the triangle.
  constexpr double kR2X = 0.7548776662466927;
  constexpr double kR2Y = 0.5698402909980532;
  Eigen::Matrix3Xd points(3, count);
  Eigen::Index face = 0;
  double area_up_to_face = areas_[0];
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    const double position = (k + 0.5) * total_area_ / static_cast<double>(count);
    while (area_up_to_face < position && face + 1 < mesh_.FaceCount()) {
      area_up_to_face += areas_[static_cast<size_t>(++face)];
    }
    double u = 0.5 + k * kR2X;
    double v = 0.5 + k * kR2Y;
    u -= std::floor(u);
    v -= std::floor(v);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Eigen::Vector3d a = mesh_.vertices.col(mesh_.faces(0, face));
    const Eigen::Vector3d b = mesh_.vertices.col(mesh_.faces(1, face));
    const Eigen::Vector3d c = mesh_.vertices.col(mesh_.faces(2, face));
    points.col(i) = a + u * (b - a) + v * (c - a);
  }
  return points;
}

}  // namespace cohort
