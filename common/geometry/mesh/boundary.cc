#include "common/geometry/mesh/boundary.h"

#include <algorithm>
#include <cassert>

namespace cohort {
namespace {

/// Each side of each face as one number: lower vertex, higher vertex.
std::vector<uint64_t> SortedSides(const TriangleMesh& mesh) {
  std::vector<uint64_t> sides;
  sides.reserve(static_cast<size_t>(3 * mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      const int32_t a = mesh.faces(corner, f);
      const int32_t b = mesh.faces((corner + 1) % 3, f);
      assert(a >= 0 && a < mesh.VertexCount());
      sides.push_back(static_cast<uint64_t>(std::min(a, b)) << 32U |
                      static_cast<uint64_t>(std::max(a, b)));
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

}  // namespace

std::vector<uint8_t> BoundaryVertices(const TriangleMesh& mesh) {
  std::vector<uint8_t> on_boundary(static_cast<size_t>(mesh.VertexCount()), 0);
  const std::vector<uint64_t> sides = SortedSides(mesh);
  for (size_t begin = 0; begin < sides.size();) {
    size_t end = begin + 1;
    while (end < sides.size() && sides[end] == sides[begin]) {
      ++end;
    }
    if (end - begin == 1) {
      on_boundary[sides[begin] >> 32U] = 1;
      on_boundary[sides[begin] & 0xFFFFFFFFU] = 1;
    }
    begin = end;
  }
  return on_boundary;
}

}  // namespace cohort
