#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Which vertices are joined by an edge of a face. Const calls may run together.
class EdgeGraph {
 public:
  explicit EdgeGraph(const TriangleMesh& mesh);

  /// The vertices joined to this one, ascending, each once. The view lives as long as the graph.
  [[nodiscard]] std::span<const int32_t> NeighboursOf(int32_t vertex) const {
    const auto v = static_cast<size_t>(vertex);
    return {neighbours_.data() + first_[v], first_[v + 1] - first_[v]};
  }

 private:
  std::vector<size_t> first_;        ///< n + 1 places in neighbours_.
  std::vector<int32_t> neighbours_;  ///< Vertex by vertex.
};

}  // namespace cohort
