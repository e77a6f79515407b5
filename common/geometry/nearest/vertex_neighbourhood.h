#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace cohort {

/// A vertex found near a query point.
struct NearVertex {
  int32_t vertex = 0;
  double squared_distance = 0;  ///< Mesh units squared.
  friend bool operator==(const NearVertex&, const NearVertex&) = default;
};

/// Finds the k nearest vertices of a query point, and all vertices within a radius. Exact, for few
/// queries or for preparation (normals, density, thinning out); NearestVertex is the fast one.
///
/// Distances are double: dx * dx + (dy * dy + dz * dz), and results come by distance, then by
/// index. A query that is one of the vertices finds itself first (or its lowest duplicate).
/// Const calls may run together.
class VertexNeighbourhood {
 public:
  /// @param vertices  3 x n, n >= 1, finite, mesh units; copied.
  [[nodiscard]] static std::unique_ptr<const VertexNeighbourhood> Build(
      const Eigen::Ref<const Eigen::Matrix3Xd>& vertices);
  virtual ~VertexNeighbourhood() = default;

  /// The k nearest vertices (all n if there are no more), k >= 1.
  /// @param found  overwritten; its memory is used again.
  virtual void Nearest(const Eigen::Vector3d& query,
                       int64_t k,
                       std::vector<NearVertex>& found) const = 0;

  /// All vertices whose squared distance is at most radius * radius, radius >= 0.
  /// @param found  overwritten; its memory is used again.
  virtual void Within(const Eigen::Vector3d& query,
                      double radius,
                      std::vector<NearVertex>& found) const = 0;

  /// The vertices as given, 3 x n.
  [[nodiscard]] virtual const Eigen::Matrix3Xd& Vertices() const = 0;
};

/// Mean over the vertices (3 x n, n >= 2) of the distance to the nearest other vertex, mesh units.
[[nodiscard]] double MeanSpacing(const VertexNeighbourhood& neighbourhood);

}  // namespace cohort
