#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/geometry/nearest/aligned_array.h"

namespace cohort {

/// For each of some meshes the displacements u_k from the n vertices of one reference to the points
/// that correspond to them, rounded to whole steps.
///
/// The step is a power of two and each mesh's own: the smallest with which all its coordinates are
/// within +-8191 steps, hence at most 1/4095 of its largest coordinate (4 um where that is 16 mm).
/// So nothing has to be known of the other meshes, nothing is cut off, and all that follows is
/// exact. (Steps end at 2^-100: smaller coordinates than half of that become 0.)
class DisplacementFields {
 public:
  /// @param vertices  n >= 1.
  explicit DisplacementFields(int64_t vertices);

  /// @param displacements  3 x n, mesh units, finite.
  void Add(const Eigen::Ref<const Eigen::Matrix3Xf>& displacements);
  /// A field as Step and Values tell it.
  /// @param values  3 n, as MayAdd wants them.
  void AddSteps(int32_t step_exponent, std::span<const int16_t> values);
  [[nodiscard]] static bool MayAdd(int32_t step_exponent, std::span<const int16_t> values);

  [[nodiscard]] int64_t VertexCount() const { return vertices_; }
  [[nodiscard]] int64_t MeshCount() const { return static_cast<int64_t>(fields_.size()); }
  /// 3 x n, mesh units, each coordinate within half a step of that added.
  [[nodiscard]] Eigen::Matrix3Xd Of(int64_t mesh) const;

  /// One step of this mesh is 2^StepExponent mesh units.
  [[nodiscard]] int32_t StepExponent(int64_t mesh) const { return FieldOf(mesh).step_exponent; }
  [[nodiscard]] double Step(int64_t mesh) const;
  /// 3 n coordinates in steps: x, y, z of the first vertex, and so on.
  [[nodiscard]] std::span<const int16_t> Values(int64_t mesh) const;
  /// Numbers of one mesh, filled up with zeros to whole rows of 32; for the kernels.
  [[nodiscard]] int64_t Stride() const { return stride_; }

 private:
  struct Field {
    int32_t step_exponent = 0;
    AlignedArray<int16_t> values;
  };

  [[nodiscard]] const Field& FieldOf(int64_t mesh) const {
    return fields_[static_cast<size_t>(mesh)];
  }
  Field& AddField(int32_t step_exponent);

  int64_t vertices_;
  int64_t stride_;
  std::vector<Field> fields_;
};

/// Root mean square distance of corresponding points, sqrt(sum_k |u_k^row - u_k^column|^2 / n), for
/// every row with every column: a quick look at how alike meshes are, which does not see what lies
/// beside the reference.
///
/// As a blocked product of whole numbers, |u|^2 + |v|^2 - 2 u v, without rounding but that of the
/// last few operations (relative 1e-15): the RMS of the fields as they were rounded when added. The
/// same bits on every instruction set and for (i, j) as for (j, i); 0 of a field with its like.
///
/// Against the displacements as they were before, with the steps s and t of the two meshes, it is
/// wrong by sqrt(3) / 2 (s + t) at most: 1/4700 of the sum of their largest coordinates, 7 um where
/// both are 16 mm. Roundings that are spread evenly add (s^2 + t^2) / 4 to the squared RMS, hence
/// to an RMS r some (s^2 + t^2) / (8 r): in this case, at 1 mm, 4 nm.
/// @param rows, columns  over the same vertices.
/// @return rows x columns, mesh units.
/// Source: thesis section 3.3 (correspondences); DESIGN 5 "preview".
[[nodiscard]] Eigen::MatrixXd CorrespondedRms(const DisplacementFields& rows,
                                              const DisplacementFields& columns);

}  // namespace cohort
