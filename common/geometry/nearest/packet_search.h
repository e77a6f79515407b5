#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "common/geometry/nearest/aligned_array.h"
#include "common/geometry/nearest/instruction_set.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "common/geometry/nearest/packet_search_kernels.h"

namespace cohort {

/// What a search found for each slot of the queries, in slot order: of slot s the vertex
/// queries.VertexOfSlot()[s]. Behind the last vertex lie the repeats of the last leaf.
struct NearestSlots {
  AlignedArray<int32_t> slots;            ///< Of the target.
  AlignedArray<float> squared_distances;  ///< Float32, as NearestVertex states.

  void Reset(int slot_count) {
    slots.Reset(static_cast<size_t>(slot_count));
    squared_distances.Reset(static_cast<size_t>(slot_count));
  }
};

/// Sums over pairs of a source point a and its nearest target point b, from which the best
/// similarity follows. Double; the same bytes on every path.
struct PairSums {
  int64_t count = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero();   ///< Sum of a.
  Eigen::Vector3d b = Eigen::Vector3d::Zero();   ///< Sum of b.
  double aa = 0;                                 ///< Sum of a . a.
  double bb = 0;                                 ///< Sum of b . b.
  double squared_distance = 0;                   ///< Sum of |T a - b|^2.
  double distance = 0;                           ///< Sum of |T a - b|, each rounded to float32.
  Eigen::Matrix3d ba = Eigen::Matrix3d::Zero();  ///< Sum of b a^T.
};

/// Which lanes of each packet take part; by default all that hold a vertex.
[[nodiscard]] AlignedArray<uint16_t> AllVertices(const PackedMesh& mesh);

/// Exact all-nearest-neighbour search between packed meshes, and the sums of scaling ICP. Holds the
/// memory that searches need: one per thread.
class PacketSearch {
 public:
  /// Uses ChooseInstructionSet(), or the fastest path where that fails: programs refuse a wrong
  /// COHORT_ISA when they start.
  PacketSearch();
  /// @param set  must be available.
  explicit PacketSearch(InstructionSet set);

  /// For every slot of `queries` the nearest vertex of `target`; the lowest vertex wins a tie.
  void Find(const PackedMesh& queries, const PackedMesh& target, NearestSlots& nearest);

  /// The same for `queries` moved by `transform`. With SearchSeed::kPrevious, `nearest` holds any
  /// slots of the target: those found before a small move make it fast.
  void FindMoved(const PackedMesh& queries,
                 const PointTransform& transform,
                 const PackedMesh& target,
                 SearchSeed seed,
                 NearestSlots& nearest);

  /// FindMoved and the sums over all pairs: a from `queries` before the move.
  [[nodiscard]] PairSums FindMovedAndSum(const PackedMesh& queries,
                                         const PointTransform& transform,
                                         const PackedMesh& target,
                                         SearchSeed seed,
                                         NearestSlots& nearest);

  /// Sums over the pairs of `nearest` whose lanes have a bit in `kept` (one entry per leaf).
  [[nodiscard]] PairSums Sum(const PackedMesh& queries,
                             const PackedMesh& target,
                             const NearestSlots& nearest,
                             std::span<const uint16_t> kept) const;

 private:
  SearchQueues Queues(const PackedMesh& target);
  /// Searches leaves [first, first + packets) of the moved queries.
  void FindBlock(const PackedMesh& queries,
                 const PointTransform& transform,
                 const PackedMesh& target,
                 int first,
                 SearchSeed seed,
                 NearestSlots& nearest);

  const PacketKernels* kernels_;
  AlignedArray<uint32_t> first_queue_;
  AlignedArray<uint32_t> second_queue_;
  AlignedArray<float> moved_points_;
  AlignedArray<float> moved_boxes_;
};

}  // namespace cohort
