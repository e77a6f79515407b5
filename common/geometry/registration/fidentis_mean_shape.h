#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "common/geometry/nearest/nearest_vertex.h"

namespace cohort {

/// Displacement of each reference vertex to its nearest vertex of one aligned mesh, float32:
/// u_k = nearest(k) - reference_k, 3 x n.
///
/// @param reference  3 x n, mesh units: the template or the mean shape of the round before.
/// @param aligned  the mesh as its ICP left it in this round.
/// Source: reference c5 and (f); thesis eq. 3.22-3.23.
[[nodiscard]] Eigen::Matrix3Xf FidentisDisplacement(
    const Eigen::Ref<const Eigen::Matrix3Xf>& reference, const NearestVertex& aligned);

/// One averaging step of the predecessor: reference_k + (u_k of mesh 0 + u_k of mesh 1 + ...) / N,
/// in float32, so that the result depends on the order of the meshes: add them in that of the job.
///
/// The same step, from the aligned template instead of the mean shape, gives the surface on which
/// the predecessor of 2016 draws its variation map. Not thread-safe.
/// Source: reference c5 and (f); thesis eq. 3.24.
class FidentisMeanShape {
 public:
  /// @param reference  3 x n, mesh units; copied.
  explicit FidentisMeanShape(const Eigen::Ref<const Eigen::Matrix3Xf>& reference);

  /// @param displacement  of the next mesh, 3 x n, as FidentisDisplacement gives it.
  void Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacement);

  /// The reference moved by the mean of what was added, 3 x n; unmoved if nothing was.
  [[nodiscard]] Eigen::Matrix3Xf Moved() const;

 private:
  Eigen::Matrix3Xf reference_;
  Eigen::Matrix3Xf sum_;
  int64_t mesh_count_ = 0;
};

}  // namespace cohort
