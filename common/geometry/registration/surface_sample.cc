#include "common/geometry/registration/surface_sample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace cohort {
namespace {

std::vector<double> FaceAreas(const TriangleMesh& mesh) {
  std::vector<double> areas(static_cast<size_t>(mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d ab = mesh.vertices.col(mesh.faces(1, f)) - a;
    const Eigen::Vector3d ac = mesh.vertices.col(mesh.faces(2, f)) - a;
    areas[static_cast<size_t>(f)] = 0.5 * ab.cross(ac).norm();
  }
  return areas;
}

double Sum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return sum;
}

/// Points with weights that have the surface's centroid and second moments.
struct MassPoints {
  Eigen::Matrix3Xd points;
  std::vector<double> weights;
};

/// The middles of the edges, each with a third of the face's area, are exact for moments up to the
/// second. The vertices, equal, if the mesh has no area.
MassPoints MassPointsOf(const TriangleMesh& mesh) {
  const std::vector<double> areas = FaceAreas(mesh);
  if (!(Sum(areas) > 0)) {
    return {mesh.vertices, std::vector<double>(static_cast<size_t>(mesh.VertexCount()), 1.0)};
  }
  MassPoints mass{Eigen::Matrix3Xd(3, 3 * mesh.faces.cols()), {}};
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    for (int corner = 0; corner < 3; ++corner) {
      mass.points.col(3 * f + corner) = 0.5 * (mesh.vertices.col(mesh.faces(corner, f)) +
                                               mesh.vertices.col(mesh.faces((corner + 1) % 3, f)));
      mass.weights.push_back(areas[static_cast<size_t>(f)]);
    }
  }
  return mass;
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

PrincipalFrame PrincipalFrameOf(const TriangleMesh& mesh) {
  const MassPoints mass = MassPointsOf(mesh);
  const double total = Sum(mass.weights);
  PrincipalFrame frame;
  for (Eigen::Index i = 0; i < mass.points.cols(); ++i) {
    frame.centroid += mass.weights[static_cast<size_t>(i)] / total * mass.points.col(i);
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < mass.points.cols(); ++i) {
    const Eigen::Vector3d d = mass.points.col(i) - frame.centroid;
    covariance += mass.weights[static_cast<size_t>(i)] / total * (d * d.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  frame.axes = eigen.eigenvectors();
  if (frame.axes.determinant() < 0) {
    frame.axes.col(2) = -frame.axes.col(2);
  }
  frame.deviations = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return frame;
}

Eigen::Matrix3Xd SampleSurface(const TriangleMesh& mesh, Eigen::Index count) {
  const std::vector<double> areas = FaceAreas(mesh);
  const double total = Sum(areas);
  if (!(total > 0)) {
    return SampleVertices(mesh, count);
  }
  // Equal steps of area along the list of faces; inside a face the R2 sequence (Roberts 2018),
  // folded from the unit square into the triangle.
  constexpr double kR2X = 0.7548776662466927;
  constexpr double kR2Y = 0.5698402909980532;
  Eigen::Matrix3Xd points(3, count);
  Eigen::Index face = 0;
  double area_up_to_face = areas[0];
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    const double position = (k + 0.5) * total / static_cast<double>(count);
    while (area_up_to_face < position && face + 1 < mesh.FaceCount()) {
      area_up_to_face += areas[static_cast<size_t>(++face)];
    }
    double u = 0.5 + k * kR2X;
    double v = 0.5 + k * kR2Y;
    u -= std::floor(u);
    v -= std::floor(v);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, face));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.faces(1, face));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.faces(2, face));
    points.col(i) = a + u * (b - a) + v * (c - a);
  }
  return points;
}

}  // namespace cohort
