#pragma once

#include <cmath>
#include <initializer_list>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort::testing {

/// A mesh from lists of points and triangles.
inline TriangleMesh MakeMesh(std::initializer_list<Eigen::Vector3d> vertices,
                             std::initializer_list<Eigen::Vector3i> faces) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
  mesh.faces.resize(3, static_cast<Eigen::Index>(faces.size()));
  Eigen::Index column = 0;
  for (const Eigen::Vector3d& vertex : vertices) {
    mesh.vertices.col(column++) = vertex;
  }
  column = 0;
  for (const Eigen::Vector3i& face : faces) {
    mesh.faces.col(column++) = face;
  }
  return mesh;
}

/// Three edges of length `size` along the axes from the origin; closed, outward.
inline TriangleMesh Tetrahedron(double size = 100) {
  return MakeMesh({{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}},
                  {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

/// An open wavy sheet of side x side vertices, 3 mm apart: 2 (side - 1)^2 faces.
inline TriangleMesh WavySheet(int side) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, Eigen::Index{side} * side);
  mesh.faces.resize(3, Eigen::Index{2} * (side - 1) * (side - 1));
  Eigen::Index face = 0;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const int v = row * side + column;
      mesh.vertices.col(v) << 3.0 * column + 0.1 * std::sin(row),
          3.0 * row + 0.1 * std::cos(column), 20 * std::sin(0.1 * row) * std::cos(0.07 * column);
      if (row + 1 < side && column + 1 < side) {
        mesh.faces.col(face++) << v, v + 1, v + side;
        mesh.faces.col(face++) << v + 1, v + side + 1, v + side;
      }
    }
  }
  return mesh;
}

/// Both meshes as one, in this order, the second one moved.
inline TriangleMesh Together(const TriangleMesh& a,
                             const TriangleMesh& b,
                             const Eigen::Vector3d& move_b) {
  TriangleMesh both;
  both.vertices.resize(3, a.vertices.cols() + b.vertices.cols());
  both.vertices << a.vertices, b.vertices.colwise() + move_b;
  both.faces.resize(3, a.faces.cols() + b.faces.cols());
  both.faces << a.faces, (b.faces.array() + static_cast<int32_t>(a.VertexCount())).matrix();
  return both;
}

}  // namespace cohort::testing
