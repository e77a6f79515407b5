#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "common/geometry/nearest/aligned_array.h"
#include "common/geometry/nearest/instruction_set.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/nearest/surface_kernels.h"

namespace cohort {

/// The nearest surface points for each slot of the queries, in slot order: of slot s the vertex
/// queries.VertexOfSlot()[s]. Behind the last vertex lie the repeats of the last leaf.
struct NearestOnSurface {
  AlignedArray<int32_t> slots;            ///< Of the target: its face is FaceOfSlot()[slot].
  AlignedArray<float> squared_distances;  ///< Computed in double, rounded once.
  AlignedArray<float> points;             ///< Per leaf 16 x, 16 y, 16 z; rounded once.

  void Reset(int slot_count) {
    slots.Reset(static_cast<size_t>(slot_count));
    squared_distances.Reset(static_cast<size_t>(slot_count));
    points.Reset(3 * static_cast<size_t>(slot_count));
  }
  /// The nearest point of query slot `slot`.
  [[nodiscard]] Eigen::Vector3f PointOfSlot(int slot) const;
};

/// Exact nearest points on a surface of all vertices of a packed mesh, and the sums of scaling ICP
/// over them. Holds the memory that searches need: one per thread.
///
/// The nearest triangle is the one whose squared distance in double is least (as
/// surface_kernels_settle.h computes it: the same on every path); the lowest face wins a tie. On an
/// edge or corner that triangles share, they are tied.
class SurfaceSearch {
 public:
  /// Uses ChooseInstructionSet(), or the fastest path where that fails, as PacketSearch does.
  SurfaceSearch();
  /// @param set  must be available.
  explicit SurfaceSearch(InstructionSet set);

  /// For every slot of `queries` the nearest point of `target`.
  void Find(const PackedMesh& queries, const PackedSurface& target, NearestOnSurface& nearest);

  /// The same for `queries` moved by `transform`. With SearchSeed::kPrevious, `nearest` holds any
  /// slots of the target: those found before a small move make it fast.
  void FindMoved(const PackedMesh& queries,
                 const PointTransform& transform,
                 const PackedSurface& target,
                 SearchSeed seed,
                 NearestOnSurface& nearest);

  /// FindMoved and the sums over all pairs: a from `queries` before the move, b the nearest point.
  [[nodiscard]] PairSums FindMovedAndSum(const PackedMesh& queries,
                                         const PointTransform& transform,
                                         const PackedSurface& target,
                                         SearchSeed seed,
                                         NearestOnSurface& nearest);

  /// Sums over the pairs of `nearest` whose lanes have a bit in `kept` (one entry per leaf).
  [[nodiscard]] PairSums Sum(const PackedMesh& queries,
                             const NearestOnSurface& nearest,
                             std::span<const uint16_t> kept) const;

 private:
  SurfaceQueues Queues(const PackedSurface& target);
  /// Searches up to kBlockPackets leaves of the moved queries from `first` on.
  void FindBlock(const PackedMesh& queries,
                 const PointTransform& transform,
                 const PackedSurface& target,
                 int first,
                 SearchSeed seed,
                 NearestOnSurface& nearest);
  void AddBlock(const PackedMesh& queries,
                int first,
                const uint16_t* kept,
                const NearestOnSurface& nearest,
                PairSumLanes& sums) const;

  const SurfaceKernels* kernels_;
  const PacketKernels* packet_kernels_;
  AlignedArray<uint32_t> first_queue_;
  AlignedArray<uint32_t> second_queue_;
  AlignedArray<float> distances_;
  AlignedArray<float> moved_points_;
  AlignedArray<float> moved_boxes_;
  AlignedArray<int32_t> own_slots_;  ///< 0, 1, ...: the pair of a query lies in its own slot.
};

}  // namespace cohort
