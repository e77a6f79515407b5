#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/base/random.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/registration/similarity.h"

namespace cohort::testing {

/// Open shell about the size of a face (mm), with a nose and without symmetry.
/// @param rows  of rows * rows vertices.
/// @param triangulation  seed: other vertices on the same surface.
/// @param person  changes the shape by some mm.
inline TriangleMesh BumpySurface(int rows, uint64_t triangulation = 1, double person = 0) {
  Random random(triangulation);
  TriangleMesh mesh;
  mesh.vertices.resize(3, Eigen::Index{rows} * rows);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows; ++j) {
      const double u = (2 * (i + random.Uniform(-0.4, 0.4)) / (rows - 1)) - 1;
      const double v = (2 * (j + random.Uniform(-0.4, 0.4)) / (rows - 1)) - 1;
      const double nose = std::exp(-(u * u / 0.03) - ((v + 0.1) * (v + 0.1) / 0.08));
      const double bumps = 5 * std::sin((5 * u) + 1) + 4 * std::cos((4 * v) + (2 * u));
      const double own = person * std::sin((3 * u) - (2 * v) + person);
      mesh.vertices.col(Eigen::Index{i} * rows + j) << 70 * u, 95 * v,
          45 * (1 - 0.6 * u * u - 0.5 * v * v) + 22 * nose + bumps + own;
    }
  }
  mesh.faces.resize(3, Eigen::Index{2} * (rows - 1) * (rows - 1));
  Eigen::Index face = 0;
  for (int i = 0; i + 1 < rows; ++i) {
    for (int j = 0; j + 1 < rows; ++j) {
      const int corner = i * rows + j;
      mesh.faces.col(face++) << corner, corner + rows, corner + rows + 1;
      mesh.faces.col(face++) << corner, corner + rows + 1, corner + 1;
    }
  }
  return mesh;
}

/// Without the faces that have a vertex within `radius` of `center`; the vertices stay.
inline void CutHole(const Eigen::Vector3d& center, double radius, TriangleMesh& mesh) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    bool inside = false;
    for (int corner = 0; corner < 3; ++corner) {
      inside = inside || (mesh.vertices.col(mesh.faces(corner, f)) - center).norm() < radius;
    }
    if (!inside) {
      const Eigen::Vector3i face = mesh.faces.col(f);
      mesh.faces.col(kept++) = face;
    }
  }
  mesh.faces.conservativeResize(Eigen::NoChange, kept);
}

inline Eigen::Matrix3d RandomRotation(Random& random) {
  const double w = random.Normal();
  const double x = random.Normal();
  const double y = random.Normal();
  const double z = random.Normal();
  return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
}

inline Similarity MakeSimilarity(double scale,
                                 double degrees,
                                 const Eigen::Vector3d& axis,
                                 const Eigen::Vector3d& translation) {
  Similarity T;
  T.scale = scale;
  T.rotation = Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()).toRotationMatrix();
  T.translation = translation;
  return T;
}

/// Angle of the rotation between two, degrees.
inline double DegreesBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle() * 180 / M_PI;
}

}  // namespace cohort::testing
