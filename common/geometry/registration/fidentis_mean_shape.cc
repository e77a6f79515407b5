#include "common/geometry/registration/fidentis_mean_shape.h"

#include <cassert>
#include <cstddef>
#include <vector>

namespace cohort {

Eigen::Matrix3Xf FidentisDisplacement(const Eigen::Ref<const Eigen::Matrix3Xf>& reference,
                                      const NearestVertex& aligned) {
  std::vector<int32_t> nearest(static_cast<size_t>(reference.cols()));
  std::vector<float> squared_distances(nearest.size());
  aligned.Find(reference, nearest, squared_distances);
  Eigen::Matrix3Xf displacement(3, reference.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k) {
    displacement.col(k) =
        aligned.Vertices().col(nearest[static_cast<size_t>(k)]) - reference.col(k);
  }
  return displacement;
}

FidentisMeanShape::FidentisMeanShape(const Eigen::Ref<const Eigen::Matrix3Xf>& reference)
    : reference_(reference), sum_(Eigen::Matrix3Xf::Zero(3, reference.cols())) {}

void FidentisMeanShape::Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacement) {
  assert(displacement.cols() == sum_.cols());
  sum_ += displacement;
  ++mesh_count_;
}

Eigen::Matrix3Xf FidentisMeanShape::Moved() const {
  if (mesh_count_ == 0) {
    return reference_;
  }
  return reference_ + sum_ / static_cast<float>(mesh_count_);
}

}  // namespace cohort
