#include "common/geometry/registration/mean_shape.h"

#include <cassert>
#include <cstddef>

namespace cohort {

Eigen::Matrix3Xd DisplacementToMesh(const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
                                    const IcpMesh& packed_reference,
                                    const Eigen::Ref<const Eigen::Matrix3Xd>& source,
                                    const IcpMesh& packed_source,
                                    const Similarity& T_reference_source,
                                    PacketSearch& search) {
  const PackedMesh& queries = packed_reference.Packed();
  const PackedMesh& target = packed_source.Packed();
  NearestSlots nearest;
  search.FindMoved(queries,
                   PackedTransform(T_reference_source.Inverse(), packed_reference, packed_source),
                   target, SearchSeed::kDescent, nearest);
  Eigen::Matrix3Xd displacement(3, reference.cols());
  for (size_t slot = 0; slot < static_cast<size_t>(reference.cols()); ++slot) {
    const int32_t k = queries.VertexOfSlot()[slot];
    const int32_t found = target.VertexOfSlot()[static_cast<size_t>(nearest.slots[slot])];
    displacement.col(k) = T_reference_source.ApplyToPoint(source.col(found)) - reference.col(k);
  }
  return displacement;
}

Eigen::Matrix3Xd DisplacementToSurface(const Eigen::Ref<const Eigen::Matrix3Xd>& reference,
                                       const IcpMesh& packed_reference,
                                       const IcpMesh& packed_source,
                                       const Similarity& T_reference_source,
                                       SurfaceSearch& search) {
  assert(packed_source.Surface() != nullptr);
  const PackedMesh& queries = packed_reference.Packed();
  NearestOnSurface nearest;
  search.FindMoved(queries,
                   PackedTransform(T_reference_source.Inverse(), packed_reference, packed_source),
                   *packed_source.Surface(), SearchSeed::kDescent, nearest);
  Eigen::Matrix3Xd displacement(3, reference.cols());
  for (int slot = 0; slot < queries.VertexCount(); ++slot) {
    const int32_t k = queries.VertexOfSlot()[static_cast<size_t>(slot)];
    const Eigen::Vector3d found = nearest.PointOfSlot(slot).cast<double>() + packed_source.Center();
    displacement.col(k) = T_reference_source.ApplyToPoint(found) - reference.col(k);
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
