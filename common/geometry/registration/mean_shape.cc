#include "common/geometry/registration/mean_shape.h"

#include <cassert>
#include <cstddef>
#include <memory>
#include <vector>

#include "common/geometry/mesh/bounds.h"
#include "common/geometry/nearest/nearest_vertex.h"

namespace cohort {

Eigen::Matrix3Xd DisplacementToMesh(const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
                                    const Eigen::Ref<const Eigen::Matrix3Xd>& source,
                                    const Similarity& T_reference_source) {
  const Eigen::Vector3d center = CentroidOf(reference);
  const Eigen::Matrix3Xd aligned = T_reference_source.Apply(source);
  const std::unique_ptr<const NearestVertex> index =
      NearestVertex::Build((aligned.colwise() - center).cast<float>());
  const Eigen::Matrix3Xf queries = (reference.colwise() - center).cast<float>();
  std::vector<int32_t> nearest(static_cast<size_t>(reference.cols()));
  std::vector<float> squared_distances(nearest.size());
  index->Find(queries, nearest, squared_distances);

  Eigen::Matrix3Xd displacement(3, reference.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k) {
    displacement.col(k) = aligned.col(nearest[static_cast<size_t>(k)]) - reference.col(k);
  }
  return displacement;
}

Eigen::Matrix3Xd MoveByMeanDisplacement(const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
                                        std::span<const Eigen::Matrix3Xd> partial_sums,
                                        int64_t mesh_count) {
  assert(mesh_count >= 1);
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, reference.cols());
  for (const Eigen::Matrix3Xd& partial_sum : partial_sums) {
    assert(partial_sum.cols() == reference.cols());
    sum += partial_sum;
  }
  return reference + sum / static_cast<double>(mesh_count);
}

}  // namespace cohort
