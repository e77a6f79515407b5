#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/geometry/nearest/aligned_array.h"

namespace cohort {

/// For each of some meshes the displacements u_k from the n vertices of one reference to the points
/// that correspond to them, float32.
class DisplacementFields {
 public:
  /// @param vertices  n >= 1.
  explicit DisplacementFields(int64_t vertices);

  /// @param displacements  3 x n, mesh units.
  void Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacements);

  [[nodiscard]] int64_t VertexCount() const { return vertices_; }
  [[nodiscard]] int64_t MeshCount() const { return static_cast<int64_t>(values_.size()); }
  /// 3 x n, as added.
  [[nodiscard]] Eigen::Map<const Eigen::Matrix3Xf> Of(int64_t mesh) const;

  /// Numbers of one mesh, filled up with zeros to whole rows of 16; for the kernels.
  [[nodiscard]] int64_t Stride() const { return stride_; }
  [[nodiscard]] const float* Data(int64_t mesh) const {
    return values_[static_cast<size_t>(mesh)].data();
  }

 private:
  int64_t vertices_;
  int64_t stride_;
  std::vector<AlignedArray<float>> values_;
};

/// Root mean square distance of corresponding points, sqrt(sum_k |u_k^row - u_k^column|^2 / n), for
/// every row with every column: a quick look at how alike meshes are, which does not see what lies
/// beside the reference.
///
/// As a blocked product, |u|^2 + |v|^2 - 2 u v; where that loses digits, because two fields are
/// nearly the same, from the differences themselves. Of fields with themselves (`rows` and
/// `columns` are one object) half is computed. The same bits on every instruction set, and the same
/// for (i, j) as for (j, i). Relative error below 1e-4, of most values below 1e-6.
/// @param rows, columns  over the same vertices.
/// @return rows x columns, mesh units.
/// Source: thesis section 3.3 (correspondences); DESIGN 5 "preview".
[[nodiscard]] Eigen::MatrixXd CorrespondedRms(const DisplacementFields& rows,
                                              const DisplacementFields& columns);

}  // namespace cohort
