#include "common/geometry/mesh/curvature.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "common/geometry/mesh/edge_graph.h"
#include "common/geometry/mesh/vertex_normals.h"

namespace cohort {
namespace {

constexpr int kRings = 2;
constexpr size_t kEnough = 12;  // twice the unknowns
constexpr size_t kMost = 64;    // a vertex in the middle of a fan may have all others around it
/// Least pivot of the normal equations, of coordinates about 1, that still determines something.
constexpr double kLeastPivot = 1e-11;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Gathers the vertices around one. Not thread-safe: it marks whom it has seen.
class Surroundings {
 public:
  explicit Surroundings(const TriangleMesh& mesh)
      : graph_(mesh), seen_by_(static_cast<size_t>(mesh.VertexCount()), -1) {}

  /// The vertex itself, then ring by ring, each ring in the order of the one before it.
  const std::vector<int32_t>& Of(int32_t vertex) {
    found_.assign(1, vertex);
    seen_by_[static_cast<size_t>(vertex)] = vertex;
    size_t ring_begin = 0;
    for (int ring = 1; ring <= kRings || found_.size() <= kEnough; ++ring) {
      const size_t ring_end = found_.size();
      for (size_t i = ring_begin; i < ring_end; ++i) {
        AddNeighboursOf(found_[i], vertex);
      }
      if (found_.size() == ring_end || found_.size() > kMost) {
        break;
      }
      ring_begin = ring_end;
    }
    return found_;
  }

 private:
  void AddNeighboursOf(int32_t vertex, int32_t center) {
    for (const int32_t neighbour : graph_.NeighboursOf(vertex)) {
      if (found_.size() > kMost) {
        return;
      }
      if (seen_by_[static_cast<size_t>(neighbour)] != center) {
        seen_by_[static_cast<size_t>(neighbour)] = center;
        found_.push_back(neighbour);
      }
    }
  }

  EdgeGraph graph_;
  std::vector<int32_t> seen_by_;
  std::vector<int32_t> found_;
};

/// Columns x, y, z: z is the normal, x any direction across it.
Eigen::Matrix3d FrameAround(const Eigen::Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  Eigen::Matrix3d frame;
  frame.col(2) = normal;
  frame.col(0) = Eigen::Vector3d::Unit(axis).cross(normal).normalized();
  frame.col(1) = normal.cross(frame.col(0));
  return frame;
}

struct Principal {
  double maximum = 0;
  double minimum = 0;
};

/// Principal curvatures of the quadric (c, d, e, a, b, f) above the origin, where a surface that
/// falls off on all sides (convex) counts as positive. Source: do Carmo, section 3.3.
Principal PrincipalOf(const Vector6d& quadric) {
  const double d = quadric(1);
  const double e = quadric(2);
  const double a = quadric(3);
  const double b = quadric(4);
  const double f = quadric(5);
  const double w = 1 + d * d + e * e;  // squared length of the normal (-d, -e, 1)
  const double root = std::sqrt(w);
  const double mean = -((1 + d * d) * f - 2 * d * e * b + (1 + e * e) * a) / (2 * w * root);
  const double gaussian = (a * f - b * b) / (w * w);
  const double deviation = std::sqrt(std::max(0.0, mean * mean - gaussian));
  return {.maximum = mean + deviation, .minimum = mean - deviation};
}

/// Fits the quadric about the first of these vertices.
Principal FitQuadric(const Eigen::Matrix3Xd& vertices,
                     const std::vector<int32_t>& around,
                     const Eigen::Vector3d& normal) {
  const Eigen::Vector3d center = vertices.col(around.front());
  double size = 0;
  for (const int32_t v : around) {
    size = std::max(size, (vertices.col(v) - center).norm());
  }
  if (!(size > 0)) {
    return {};
  }
  const Eigen::Matrix3d frame = FrameAround(normal) / size;  // coordinates of at most 1
  Matrix6d A = Matrix6d::Zero();
  Vector6d rhs = Vector6d::Zero();
  for (const int32_t v : around) {
    const Eigen::Vector3d p = frame.transpose() * (vertices.col(v) - center);
    Vector6d terms;
    terms << 1, p.x(), p.y(), 0.5 * p.x() * p.x(), p.x() * p.y(), 0.5 * p.y() * p.y();
    A += terms * terms.transpose();
    rhs += terms * p.z();
  }
  const Eigen::LDLT<Matrix6d> solver(A / static_cast<double>(around.size()));
  if (!(solver.vectorD().minCoeff() > kLeastPivot)) {
    return {};
  }
  const Vector6d quadric = solver.solve(rhs / static_cast<double>(around.size()));
  const Principal principal = PrincipalOf(quadric);
  return {.maximum = principal.maximum / size, .minimum = principal.minimum / size};
}

}  // namespace

VertexCurvatures CurvaturesOf(const TriangleMesh& mesh) {
  VertexCurvatures curvatures;
  curvatures.maximum = Eigen::VectorXd::Zero(mesh.VertexCount());
  curvatures.minimum = Eigen::VectorXd::Zero(mesh.VertexCount());
  const Eigen::Matrix3Xd normals = VertexNormals(mesh);
  Surroundings surroundings(mesh);
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    const std::vector<int32_t>& around = surroundings.Of(static_cast<int32_t>(v));
    if (!normals.col(v).isZero(0)) {
      const Principal principal = FitQuadric(mesh.vertices, around, normals.col(v));
      curvatures.maximum(v) = principal.maximum;
      curvatures.minimum(v) = principal.minimum;
    }
  }
  return curvatures;
}

}  // namespace cohort
