#include "common/pairs/signature.h"

#include <algorithm>
#include <cassert>

namespace cohort {

std::vector<int32_t> SignatureVertices(int64_t n) {
  assert(n >= 1);
  const int64_t count = std::min(n, kSignaturePoints);
  std::vector<int32_t> vertices;
  vertices.reserve(static_cast<size_t>(count));
  for (int64_t k = 0; k < count; ++k) {
    vertices.push_back(static_cast<int32_t>(k * n / count));
  }
  return vertices;
}

Eigen::Matrix3Xf SignatureOf(const Eigen::Ref<const Eigen::Matrix3Xd>& displacements) {
  return displacements(Eigen::all, SignatureVertices(displacements.cols())).cast<float>();
}

}  // namespace cohort
