#pragma once

#include "common/geometry/nearest/packet_kernels.h"

namespace cohort {

/// Squared distance and slot, per lane.
template <class S>
struct Nearest16 {
  typename S::F distance;
  typename S::I slot;
};

/// The nearer one; `a` on a tie.
template <class S>
inline Nearest16<S> NearerOf(const Nearest16<S>& a, const Nearest16<S>& b) {
  return {S::Min(a.distance, b.distance),
          S::SelectI(S::Less(b.distance, a.distance), b.slot, a.slot)};
}

/// Nearest of points j ... j + N - 1 of the leaf, as a tournament: short chains of dependence.
template <class S, int N>
inline Nearest16<S> Tournament(const Lanes3<S>& p, const float* leaf, int j) {
  if constexpr (N == 1) {
    return {PointsToPoint<S>(p, leaf, j), S::SetI(j)};
  } else {
    return NearerOf<S>(Tournament<S, N / 2>(p, leaf, j), Tournament<S, N / 2>(p, leaf, j + N / 2));
  }
}

/// Lanes where both slots are equally far and the first holds the lower vertex. Rare: outlined.
template <class S>
[[gnu::noinline]] typename S::M LowerVertex(typename S::M tied,
                                            typename S::I found,
                                            typename S::I slot,
                                            const int32_t* vertices) {
  alignas(64) int32_t found_slots[16];
  alignas(64) int32_t slots[16];
  S::StoreI(found_slots, found);
  S::StoreI(slots, slot);
  unsigned bits = S::Bits(tied);
  for (int lane = 0; lane < 16; ++lane) {
    if (vertices[found_slots[lane]] >= vertices[slots[lane]]) {
      bits &= ~(1U << static_cast<unsigned>(lane));
    }
  }
  return S::FromBits(bits);
}

/// Measures one leaf and updates the packet's lanes; the lowest vertex wins a tie. The vertices of
/// a leaf ascend, so that inside it the first of equal ones is the right one.
template <class S>
inline void MeasureLeaf(const Lanes3<S>& p,
                        const PackedMesh::View& target,
                        int leaf_index,
                        Nearest16<S>& nearest) {
  const float* leaf = target.points + int64_t{leaf_index} * kPacketFloats;
  constexpr int kStep = S::kTournament;
  Nearest16<S> here = Tournament<S, kStep>(p, leaf, 0);
#pragma GCC unroll 16
  for (int j = kStep; j < 16; j += kStep) {
    here = NearerOf<S>(here, Tournament<S, kStep>(p, leaf, j));
  }
  const typename S::I found = S::AddI(here.slot, S::SetI(leaf_index * 16));
  const typename S::M tied =
      S::And(S::Equal(here.distance, nearest.distance), S::Differ(found, nearest.slot));
  const typename S::M nearer = S::Less(here.distance, nearest.distance);
  typename S::I slot = S::SelectI(nearer, found, nearest.slot);
  if (__builtin_expect(static_cast<int>(S::Any(tied)), 0) != 0) {
    slot = S::SelectI(LowerVertex<S>(tied, found, nearest.slot, target.vertices), found, slot);
  }
  nearest = {S::Min(here.distance, nearest.distance), slot};
}

template <class S>
inline Nearest16<S> LoadNearest(const BlockState& state, uint32_t packet) {
  return {S::Load(state.best + packet * kPacketLanes),
          S::LoadI(state.slot + packet * kPacketLanes)};
}

template <class S>
inline void StoreNearest(const Nearest16<S>& nearest, uint32_t packet, BlockState& state) {
  S::Store(state.best + packet * kPacketLanes, nearest.distance);
  S::StoreI(state.slot + packet * kPacketLanes, nearest.slot);
}

/// Squared distances to the points in the given slots.
template <class S>
inline typename S::F ToSlots(const Lanes3<S>& p,
                             const PackedMesh::View& target,
                             typename S::I slots) {
  return S::SquaredNorm(S::Sub(p.x, S::GatherPoints(target.points, slots, 0)),
                        S::Sub(p.y, S::GatherPoints(target.points, slots, 1)),
                        S::Sub(p.z, S::GatherPoints(target.points, slots, 2)));
}

/// First upper bounds: from the leaf that the descent ended in, or from the slots given.
template <class S>
inline void Seed(const QueryBlock& block,
                 const PackedMesh::View& target,
                 SearchSeed seed,
                 const int32_t* previous,
                 BlockState& state) {
  if (seed == SearchSeed::kDescent) {
    Descend<S>(block, target, state);
  }
  for (int u = 0; u < block.packets; ++u) {
    const Lanes3<S> p = LoadPoints<S>(block.points + u * kPacketFloats);
    Nearest16<S> nearest = {S::Set(kFarAway), S::SetI(0)};
    if (seed == SearchSeed::kDescent) {
      MeasureLeaf<S>(p, target, state.seed[u], nearest);
    } else {
      state.seed[u] = -1;
      nearest.slot = S::LoadI(previous + u * kPacketLanes);
      nearest.distance = ToSlots<S>(p, target, nearest.slot);
    }
    StoreNearest<S>(nearest, static_cast<uint32_t>(u), state);
    S::Store(state.limit + u * kPacketLanes, nearest.distance);
    state.bound[u] = S::GreatestOf(nearest.distance);
  }
}

/// PacketKernels::find with fused multiply-add.
template <class S>
void FindFused(const QueryBlock& block,
               const PackedMesh::View& target,
               SearchSeed seed,
               const SearchQueues& queues,
               int32_t* slots,
               float* squared_distances) {
  BlockState state;
  Seed<S>(block, target, seed, slots, state);
  uint32_t* in = queues.first;
  uint32_t* out = queues.second;
  const int listed = ListLeaves<S>(block, target, state, in, out);
  const int kept = FilterLeaves<S>(block, target, state, in, listed, out);
  for (int i = 0; i < kept; ++i) {
    const uint32_t packet = out[i] >> kPacketShift;
    const Lanes3<S> p = LoadPoints<S>(block.points + packet * kPacketFloats);
    Nearest16<S> nearest = LoadNearest<S>(state, packet);
    MeasureLeaf<S>(p, target, static_cast<int>(out[i] & kNodeMask), nearest);
    StoreNearest<S>(nearest, packet, state);
  }
  for (int u = 0; u < block.packets; ++u) {
    S::StoreI(slots + u * kPacketLanes, S::LoadI(state.slot + u * kPacketLanes));
    S::Store(squared_distances + u * kPacketLanes, S::Load(state.best + u * kPacketLanes));
  }
}

}  // namespace cohort
