#include "common/geometry/mesh/boundary.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace cohort {
namespace {

/// The sides of all faces by their lower vertex: those of v are `higher[first[v]]` up to
/// `higher[first[v + 1]]`, each by its higher vertex, in any order.
struct Sides {
  std::vector<int64_t> first;
  std::vector<int32_t> higher;
};

template <typename Visit>
void ForEachSide(const TriangleMesh& mesh, Visit visit) {
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      const int32_t a = mesh.faces(corner, f);
      const int32_t b = mesh.faces(corner == 2 ? 0 : corner + 1, f);
      assert(a >= 0 && a < mesh.VertexCount());
      visit(static_cast<size_t>(std::min(a, b)), std::max(a, b));
    }
  }
}

/// A counting sort: a vertex has few sides, so that little is left to sort.
Sides SidesByLowerVertex(const TriangleMesh& mesh) {
  const auto n = static_cast<size_t>(mesh.VertexCount());
  Sides sides{.first = std::vector<int64_t>(n + 2, 0),
              .higher = std::vector<int32_t>(static_cast<size_t>(3 * mesh.FaceCount()))};
  // Counted two places up, so that filling them in leaves each start where it belongs.
  ForEachSide(mesh, [&](size_t lower, int32_t) { ++sides.first[lower + 2]; });
  for (size_t v = 2; v < sides.first.size(); ++v) {
    sides.first[v] += sides.first[v - 1];
  }
  ForEachSide(mesh, [&](size_t lower, int32_t higher) {
    sides.higher[static_cast<size_t>(sides.first[lower + 1]++)] = higher;
  });
  return sides;
}

}  // namespace

std::vector<uint8_t> BoundaryVertices(const TriangleMesh& mesh) {
  const auto n = static_cast<size_t>(mesh.VertexCount());
  std::vector<uint8_t> on_boundary(n, 0);
  Sides sides = SidesByLowerVertex(mesh);
  for (size_t v = 0; v < n; ++v) {
    const auto begin = sides.higher.begin() + sides.first[v];
    const auto end = sides.higher.begin() + sides.first[v + 1];
    std::sort(begin, end);
    for (auto side = begin; side != end;) {
      const auto next = std::find_if(side, end, [side](int32_t other) { return other != *side; });
      if (next - side == 1) {
        on_boundary[v] = 1;
        on_boundary[static_cast<size_t>(*side)] = 1;
      }
      side = next;
    }
  }
  return on_boundary;
}

}  // namespace cohort
