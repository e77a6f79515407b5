#include "common/geometry/mesh/edge_graph.h"

#include <algorithm>
#include <cassert>

namespace cohort {

EdgeGraph::EdgeGraph(const TriangleMesh& mesh) {
  std::vector<uint64_t> edges;  // from, to: sorted, they are the lists of neighbours one by one
  edges.reserve(static_cast<size_t>(6 * mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      const auto a = static_cast<uint64_t>(mesh.faces(corner, f));
      const auto b = static_cast<uint64_t>(mesh.faces((corner + 1) % 3, f));
      assert(a < static_cast<uint64_t>(mesh.VertexCount()));
      if (a != b) {
        edges.push_back(a << 32U | b);
        edges.push_back(b << 32U | a);
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  first_.assign(static_cast<size_t>(mesh.VertexCount()) + 1, 0);
  neighbours_.reserve(edges.size());
  for (const uint64_t edge : edges) {
    ++first_[(edge >> 32U) + 1];
    neighbours_.push_back(static_cast<int32_t>(edge & 0xFFFFFFFFU));
  }
  for (size_t v = 1; v < first_.size(); ++v) {
    first_[v] += first_[v - 1];
  }
}

}  // namespace cohort
