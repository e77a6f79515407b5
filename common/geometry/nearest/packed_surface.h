#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/aligned_array.h"
#include "common/geometry/nearest/packed_mesh.h"

namespace cohort {

/// Triangles of one mesh in the order in which surface search reads them. Immutable; const use may
/// run together.
///
/// The triangles lie in leaves of 16 neighbours, ordered as PackedMesh orders their centroids. Slot
/// s = 16 * leaf + lane holds face FaceOfSlot()[s]; within a leaf the faces ascend. Above the
/// leaves lies a hierarchy of boxes, 16 to one. The layout depends on nothing but the coordinates
/// and the faces. Triangles without area count as the segment or point that they are. Some 130
/// bytes a face.
class PackedSurface {
 public:
  static constexpr int kLanes = PackedMesh::kLanes;
  static constexpr int kFrameRows = 17;     ///< Of 16 floats.
  static constexpr int kTurnedFloats = 16;  ///< A cache line.
  static constexpr int kCornerFloats = 12;

  /// Addresses as the kernels read them; all 64-byte aligned.
  struct View {
    PackedMesh::View boxes;  ///< Levels and number of leaves; the rest is not set.
    /// Per leaf rows of 16 floats, for a triangle P, Q, R whose longest edge is PQ and whose plane
    /// has the axes X along PQ, Y towards R, and Z: P (3), X (3), Y (3), Z (3), |PQ|, x and y of R,
    /// 1 / |QR|^2, 1 / |PR|^2 (0 for edges without length).
    const float* frames;
    /// Per leaf a box in turned axes, the third along the normals: centre (3), axes (9), half
    /// sides (3), one unused.
    const float* turned_boxes;
    /// Per slot three corners (9) ascending by x, y, z; the bits of the face; two unused.
    const float* corners;
    float reach;  ///< No leaf is wider (diagonal of its box).
  };

  /// @param vertices  3 x n, finite, at most PackedMesh::kMostCoordinate, in the centred frame of
  ///                  the queries, mesh units; copied.
  /// @param faces  3 x m, 1 <= m < 2^27, each index in [0, n).
  PackedSurface(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                const Eigen::Ref<const Matrix3Xi>& faces);

  [[nodiscard]] int FaceCount() const { return face_count_; }
  [[nodiscard]] int LeafCount() const { return leaf_count_; }
  /// Slots with the repeats at the end; the first FaceCount() hold each face once.
  [[nodiscard]] int SlotCount() const { return leaf_count_ * kLanes; }
  [[nodiscard]] std::span<const int32_t> FaceOfSlot() const { return faces_; }
  [[nodiscard]] const View& Addresses() const { return view_; }
  /// Memory held.
  [[nodiscard]] int64_t ByteCount() const;

 private:
  void FillLeaf(int leaf,
                const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                const Eigen::Ref<const Matrix3Xi>& faces,
                float* box);
  void BuildLevels(std::vector<float> boxes);

  int face_count_;
  int leaf_count_;
  std::vector<int32_t> faces_;
  AlignedArray<float> frames_;
  AlignedArray<float> turned_boxes_;
  AlignedArray<float> corners_;
  std::vector<AlignedArray<float>> levels_;
  View view_{};
};

}  // namespace cohort
