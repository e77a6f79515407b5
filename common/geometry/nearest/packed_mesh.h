#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/geometry/nearest/aligned_array.h"

namespace cohort {

/// Vertices of one mesh in the order in which packet search reads them. Immutable; const use may
/// run together.
///
/// The vertices lie in leaves of 16 neighbours (kd-tree, split at the median of the longest side;
/// all leaves but the last are full, the last is filled up with repeats). Slot s = 16 * leaf + lane
/// holds vertex VertexOfSlot()[s]; within a leaf the vertices ascend. Above the leaves lies a
/// hierarchy of boxes, 16 to one. The layout depends on nothing but the coordinates.
/// Some 20 bytes a vertex.
class PackedMesh {
 public:
  static constexpr int kLanes = 16;      ///< Vertices of a leaf, children of a box.
  static constexpr int kMostLevels = 8;  ///< 16^8 leaves.
  /// Squares of larger coordinates leave float32.
  static constexpr float kMostCoordinate = 1e18F;

  /// Addresses as the kernels read them; all 64-byte aligned.
  struct View {
    const float* points;  ///< Per leaf 16 x, 16 y, 16 z.
    const float* boxes;   ///< Per leaf low x, y, z, high x, y, z, two unused.
    /// Level 0 bounds the leaves: per group of 16 children 16 low x, y, z, then 16 high x, y, z.
    /// A missing child is a box of infinite distance.
    const float* levels[kMostLevels];
    const int32_t* vertices;  ///< Vertex of each slot.
    int level_count;
    int leaf_count;
    int vertex_count;
  };

  /// @param vertices  3 x n, n >= 1, finite, at most kMostCoordinate, centred, mesh units; copied.
  explicit PackedMesh(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices);

  /// A copy of another one, from what its leaves hold: nothing is sorted again.
  /// @param vertex_of_slot  VertexOfSlot() of the other.
  /// @param points          Its View::points: 3 floats a slot.
  [[nodiscard]] static PackedMesh FromSlots(int vertex_count,
                                            std::span<const int32_t> vertex_of_slot,
                                            std::span<const float> points);

  [[nodiscard]] int VertexCount() const { return vertex_count_; }
  [[nodiscard]] int LeafCount() const { return leaf_count_; }
  /// Slots with the repeats at the end; the first VertexCount() hold each vertex once.
  [[nodiscard]] int SlotCount() const { return leaf_count_ * kLanes; }
  [[nodiscard]] std::span<const int32_t> VertexOfSlot() const { return vertices_; }
  [[nodiscard]] Eigen::Vector3f PointOfSlot(int slot) const;
  [[nodiscard]] const View& Addresses() const { return view_; }
  /// Of the bounding box.
  [[nodiscard]] double Diagonal() const { return diagonal_; }
  /// Memory held.
  [[nodiscard]] int64_t ByteCount() const;

 private:
  /// Makes room for the leaves of so many vertices.
  explicit PackedMesh(int vertex_count);
  /// Leaves, boxes and the view. @param coordinate  float of (leaf, side, lane).
  template <typename Coordinate>
  void FillLeaves(Coordinate coordinate);
  void BuildLevels();
  [[nodiscard]] double MeasureDiagonal() const;

  int vertex_count_;
  int leaf_count_;
  double diagonal_ = 0;
  std::vector<int32_t> vertices_;
  AlignedArray<float> points_;
  AlignedArray<float> boxes_;
  std::vector<AlignedArray<float>> levels_;
  View view_{};
};

}  // namespace cohort
