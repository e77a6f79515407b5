#pragma once

#include "common/geometry/nearest/surface_kernels_measure.h"
#include "common/geometry/nearest/surface_kernels_settle.h"

namespace cohort {

// Search in float32, with a margin for its rounding; what is within the margin is settled in double
// (surface_kernels_settle.h). Packets of 16 neighbouring queries go together:
//   1. a descent to the leaf nearest to the packet's middle; its triangles' first corners bound the
//      distances of all lanes;
//   2. level by level, boxes that are nearer to the packet's box than the largest bound;
//   3. of the leaves left, the turned boxes against 16 queries: the nearest is the lane's seed;
//   4. each query against the 16 triangles of its seed, which nearly always holds its nearest: the
//      bound of the lane;
//   5. each query against the 16 triangles of the other leaves whose turned boxes are nearer;
//   6. triangles within the margin of the lane's least distance are settled: mostly one, or those
//      around the edge or corner that is nearest.
// With the slots of an earlier search, their leaves are the seeds and steps 1 and 3 are not needed.
// S and R: the sixteen lanes and the registers of the instruction set.

/// Pairs of a query and a leaf that are measured before the best are picked.
constexpr int kPairsAtOnce = 240;

struct alignas(64) SurfaceState {
  BlockState block;                          ///< For the listing of boxes.
  int32_t seeds[kBlockPackets][16];          ///< Leaf of each lane.
  DistanceRow seed_rows[kBlockPackets][16];  ///< To the triangles of the seeds.
  float limit[kBlockPackets][16];            ///< Nothing farther can be nearest.
  DistanceRow least[16];                     ///< Of each lane, triangle by triangle of the leaves.
  DistanceRow rows[kPairsAtOnce + 16];
  uint32_t pairs[kPairsAtOnce + 32];  ///< Leaf * 16 + lane.
  FoundPairs found;
  SettledQueries settled;
};

/// Bounds the packets by the first corners of the leaf that the descent ended in.
template <class S>
inline void BoundByDescent(const QueryBlock& block,
                           const PackedSurface::View& target,
                           SurfaceState& state) {
  Descend<S>(block, target.boxes, state.block);
  for (int u = 0; u < block.packets; ++u) {
    const Lanes3<S> p = LoadPoints<S>(PointsOfPacket<S>(block, u));
    const float* leaf = FramesOfLeaf<S>(target, state.block.seed[u]);
    typename S::F least = S::Set(kFarAway);
    for (int j = 0; j < 16; ++j) {
      least = S::Min(least, PointsToPoint<S>(p, leaf, j));
    }
    state.block.bound[u] = S::GreatestOf(WithRounding<S>(least, target));
  }
}

/// Sets the limits of the packet's lanes from the least distances in their rows.
template <class S>
inline void SetLimits(const PackedSurface::View& target,
                      const DistanceRow* rows,
                      int packet,
                      SurfaceState& state) {
  alignas(64) float least[16];
  for (int lane = 0; lane < 16; ++lane) {
    least[lane] = S::LeastOf(S::Load(rows[lane].distances));
  }
  S::Store(state.limit[packet], WithRounding<S>(S::Load(least), target));
}

/// Measures the triangles of the lanes' seeds.
template <class S, class R>
inline void MeasureSeeds(const QueryBlock& block,
                         const PackedSurface::View& target,
                         int packet,
                         SurfaceState& state) {
  for (uint32_t lane = 0; lane < 16; ++lane) {
    MeasureTriangles<R>(PointsOfPacket<R>(block, packet), lane,
                        FramesOfLeaf<R>(target, state.seeds[packet][lane]),
                        state.seed_rows[packet][lane]);
  }
  SetLimits<S>(target, state.seed_rows[packet], packet, state);
}

/// Bounds the packets by the leaves of the triangles found before.
template <class S, class R>
inline void BoundByPrevious(const QueryBlock& block,
                            const PackedSurface::View& target,
                            const int32_t* slots,
                            SurfaceState& state) {
  for (int u = 0; u < block.packets; ++u) {
    for (int lane = 0; lane < 16; ++lane) {
      state.seeds[u][lane] = slots[u * 16 + lane] / 16;
    }
    MeasureSeeds<S, R>(block, target, u, state);
    state.block.bound[u] = S::GreatestOf(S::Load(state.limit[u]));
  }
}

/// Adds the triangles of the measured pairs that are within the limits of their lanes.
template <class S, class R>
inline void AddFound(const QueryBlock& block,
                     const PackedSurface::View& target,
                     int packet,
                     const DistanceRow* rows,
                     int count,
                     SurfaceState& state) {
  FoundPairs& found = state.found;
  for (int i = 0; i < count; ++i) {
    if (found.count > FoundPairs::kMost - 16) {
      SettlePairs<R>(block.points, target, found, state.settled);
    }
    const uint32_t lane = state.pairs[i] % 16;
    const uint32_t slot = state.pairs[i] - lane;
    const typename S::M near =
        S::LessEqual(S::Load(rows[i].distances), S::Set(state.limit[packet][lane]));
    __builtin_memset(found.queries + found.count, packet * 16 + static_cast<int>(lane), 16);
    found.count += S::StoreLanes(found.slots + found.count, near, slot);
  }
}

/// Measures the listed pairs of one packet, lowers the limits of its lanes and adds what is within.
template <class S, class R>
inline void MeasureRows(const QueryBlock& block,
                        const PackedSurface::View& target,
                        int packet,
                        int count,
                        SurfaceState& state) {
  for (int i = 0; i < count; ++i) {
    const uint32_t lane = state.pairs[i] % 16;
    MeasureTriangles<R>(PointsOfPacket<R>(block, packet), lane,
                        FramesOfLeaf<R>(target, state.pairs[i] / 16), state.rows[i]);
    float* least = state.least[lane].distances;
    S::Store(least, S::Min(S::Load(least), S::Load(state.rows[i].distances)));
  }
  SetLimits<S>(target, state.least, packet, state);
  AddFound<S, R>(block, target, packet, state.rows, count, state);
}

/// The leaves listed for one packet, and room for 16 distances for each.
struct PacketLeaves {
  int packet;
  const uint32_t* entries;
  int count;
  float* distances;
};

/// Measures the turned boxes of the leaves; the lanes' nearest boxes.
template <class S>
inline typename S::I MeasureBoxes(const QueryBlock& block,
                                  const PackedSurface::View& target,
                                  const PacketLeaves& leaves) {
  const Lanes3<S> p = LoadPoints<S>(PointsOfPacket<S>(block, leaves.packet));
  typename S::F least = S::Set(kFarAway);
  typename S::I nearest = S::SetI(static_cast<int32_t>(leaves.entries[0] & kNodeMask));
  for (int64_t i = 0; i < leaves.count; ++i) {
    const auto leaf = static_cast<int32_t>(leaves.entries[i] & kNodeMask);
    const typename S::F distance =
        PointsToTurnedBox<S>(p, target.turned_boxes + int64_t{leaf} * PackedSurface::kTurnedFloats);
    S::Store(leaves.distances + i * 16, distance);
    nearest = S::SelectI(S::Less(distance, least), S::SetI(leaf), nearest);
    least = S::Min(least, distance);
  }
  return nearest;
}

/// Finds the triangles that may be nearest to the lanes of one packet among its leaves.
template <class S, class R>
inline void SearchPacket(const QueryBlock& block,
                         const PackedSurface::View& target,
                         const PacketLeaves& leaves,
                         SearchSeed seed,
                         SurfaceState& state) {
  const int packet = leaves.packet;
  const typename S::I nearest = MeasureBoxes<S>(block, target, leaves);
  if (seed == SearchSeed::kDescent) {
    S::StoreI(state.seeds[packet], nearest);
    MeasureSeeds<S, R>(block, target, packet, state);
  }
  for (int lane = 0; lane < 16; ++lane) {
    S::Store(state.least[lane].distances, S::Load(state.seed_rows[packet][lane].distances));
  }
  const typename S::I seeds = S::LoadI(state.seeds[packet]);
  int pairs = 0;
  for (int64_t i = 0; i < leaves.count; ++i) {
    const uint32_t leaf = leaves.entries[i] & kNodeMask;
    const typename S::M near =
        S::And(S::LessEqual(S::Load(leaves.distances + i * 16), S::Load(state.limit[packet])),
               S::Differ(seeds, S::SetI(static_cast<int32_t>(leaf))));
    pairs += S::StoreLanes(state.pairs + pairs, near, leaf * 16);
    if (pairs > kPairsAtOnce) {
      MeasureRows<S, R>(block, target, packet, pairs, state);
      pairs = 0;
    }
  }
  MeasureRows<S, R>(block, target, packet, pairs, state);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    state.pairs[lane] = static_cast<uint32_t>(state.seeds[packet][lane]) * 16 + lane;
  }
  AddFound<S, R>(block, target, packet, state.seed_rows[packet], 16, state);
}

template <class R>
inline void StartSettling(FoundPairs& found, SettledQueries& settled) {
  found.count = 0;
  for (Settled& query : settled.queries) {
    query = {.squared_distance = __builtin_huge_val(), .face = 0, .slot = 0, .point = {}};
  }
}

template <class R>
inline void WriteResults(const SettledQueries& settled,
                         int packets,
                         const SurfaceResults& results) {
  for (int i = 0; i < packets * 16; ++i) {
    const Settled& query = settled.queries[i];
    results.slots[i] = query.slot;
    results.squared_distances[i] = static_cast<float>(query.squared_distance);
    for (int side = 0; side < 3; ++side) {
      results.points[i / 16 * kPacketFloats + kPacketLanes * side + i % 16] = query.point[side];
    }
  }
}

/// SurfaceKernels::find.
template <class S, class R>
void FindOnSurface(const QueryBlock& block,
                   const PackedSurface::View& target,
                   SearchSeed seed,
                   const SurfaceQueues& queues,
                   const SurfaceResults& results) {
  SurfaceState state;
  if (seed == SearchSeed::kDescent) {
    BoundByDescent<S>(block, target, state);
  } else {
    BoundByPrevious<S, R>(block, target, results.slots, state);
  }
  uint32_t* leaves = queues.leaves.first;
  uint32_t* other = queues.leaves.second;
  const int listed = ListLeaves<S>(block, target.boxes, state.block, leaves, other);
  StartSettling<R>(state.found, state.settled);
  int begin = 0;  // The queue is in the order of the packets.
  for (int u = 0; u < block.packets; ++u) {
    int end = begin;
    while (end < listed && leaves[end] >> kPacketShift == static_cast<uint32_t>(u)) {
      ++end;
    }
    SearchPacket<S, R>(block, target,
                       {.packet = u,
                        .entries = leaves + begin,
                        .count = end - begin,
                        .distances = queues.distances},
                       seed, state);
    begin = end;
  }
  SettlePairs<R>(block.points, target, state.found, state.settled);
  WriteResults<R>(state.settled, block.packets, results);
}

}  // namespace cohort
