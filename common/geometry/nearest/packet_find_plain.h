#pragma once

#include "common/geometry/nearest/packet_kernels.h"

namespace cohort {

// Search where there is no fused multiply-add. The plain squared distance x x + (y y + z z) and the
// fused one that counts each lie within 3 roundings of the true value, so that the vertex with the
// least fused distance is among those whose plain distance is within kMargin of the least plain
// one. Almost always that is one vertex, whose fused distance is then computed in software; if the
// second best comes that close, the leaves of the packet are settled with fused distances.

/// (1 + 2^-24)^12 < 1 + kMargin, with room.
constexpr float kMargin = 1e-6F;
/// Where squares leave the normal numbers their relative error is unbounded.
constexpr float kLeastNormal = 1.2e-38F;

inline float WithMargin(float squared_distance) {
  return squared_distance * (1 + kMargin) + kLeastNormal;
}

inline float FusedSquaredNorm(float x, float y, float z) {
  return __builtin_fmaf(x, x, __builtin_fmaf(y, y, z * z));
}

/// Updates best, second and slot of the packet with one leaf that it has not seen.
template <class S>
inline void MeasureLeafPlain(const float* points,
                             const PackedMesh::View& target,
                             int leaf_index,
                             uint32_t packet,
                             BlockState& state) {
  const float* leaf = target.points + int64_t{leaf_index} * kPacketFloats;
  using F4 = typename S::F4;
  using I4 = typename S::I4;
  const auto load = [](const auto* from, auto& to) { __builtin_memcpy(&to, from, sizeof(to)); };
  const auto store = [](auto* to, const auto& from) { __builtin_memcpy(to, &from, sizeof(from)); };
  for (int quarter = 0; quarter < 16; quarter += 4) {
    F4 x;
    F4 y;
    F4 z;
    F4 best;
    F4 second;
    I4 slot;
    load(points + quarter, x);
    load(points + 16 + quarter, y);
    load(points + 32 + quarter, z);
    load(state.best + packet * kPacketLanes + quarter, best);
    load(state.second + packet * kPacketLanes + quarter, second);
    load(state.slot + packet * kPacketLanes + quarter, slot);
    for (int j = 0; j < 16; ++j) {
      const F4 distance = S::SquaredNorm4(x - leaf[j], y - leaf[16 + j], z - leaf[32 + j]);
      const I4 nearer = distance < best;
      slot = (nearer & (leaf_index * 16 + j)) | (~nearer & slot);
      second = S::Min4(second, S::Max4(best, distance));
      best = S::Min4(best, distance);
    }
    store(state.best + packet * kPacketLanes + quarter, best);
    store(state.second + packet * kPacketLanes + quarter, second);
    store(state.slot + packet * kPacketLanes + quarter, slot);
  }
}

template <class S>
inline void SeedPlain(const QueryBlock& block,
                      const PackedMesh::View& target,
                      SearchSeed seed,
                      const int32_t* previous,
                      BlockState& state) {
  if (seed == SearchSeed::kDescent) {
    Descend<S>(block, target, state);
  }
  for (int i = 0; i < block.packets * 16; ++i) {
    state.best[i] = kFarAway;
    state.second[i] = kFarAway;
    state.slot[i] = 0;
  }
  for (int u = 0; u < block.packets; ++u) {
    const float* points = block.points + u * kPacketFloats;
    float* limit = state.limit + u * kPacketLanes;
    if (seed == SearchSeed::kDescent) {
      MeasureLeafPlain<S>(points, target, state.seed[u], static_cast<uint32_t>(u), state);
      S::Store(limit, S::Load(state.best + u * kPacketLanes));
    } else {
      state.seed[u] = -1;
      const Lanes3<S> p = LoadPoints<S>(points);
      const typename S::I slots = S::LoadI(previous + u * kPacketLanes);
      S::Store(limit, S::SquaredNorm(S::Sub(p.x, S::GatherPoints(target.points, slots, 0)),
                                     S::Sub(p.y, S::GatherPoints(target.points, slots, 1)),
                                     S::Sub(p.z, S::GatherPoints(target.points, slots, 2))));
    }
    for (int lane = 0; lane < 16; ++lane) {
      limit[lane] = WithMargin(limit[lane]);
    }
    state.bound[u] = S::GreatestOf(S::Load(limit));
  }
}

/// Replaces best and slot by the fused distance to the point in `slot` if that is nearer, or as
/// near and of a lower vertex.
inline void Settle(
    const float* point, const PackedMesh::View& target, int slot, float& best, int32_t& best_slot) {
  const float* leaf = target.points + int64_t{slot / 16} * kPacketFloats;
  const int lane = slot % 16;
  const float distance = FusedSquaredNorm(point[0] - leaf[lane], point[16] - leaf[16 + lane],
                                          point[32] - leaf[32 + lane]);
  if (distance < best || (distance == best && target.vertices[slot] < target.vertices[best_slot])) {
    best = distance;
    best_slot = slot;
  }
}

inline void SettleLeaf(
    const float* point, const PackedMesh::View& target, int leaf, float& best, int32_t& best_slot) {
  for (int j = 0; j < 16; ++j) {
    Settle(point, target, leaf * 16 + j, best, best_slot);
  }
}

/// Fused distances of one packet; `leaves` are those it measured, besides its seed.
inline void SettlePacket(const float* points,
                         const PackedMesh::View& target,
                         const uint32_t* leaves,
                         int leaf_count,
                         uint32_t packet,
                         BlockState& state) {
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t i = packet * 16 + lane;
    const bool certain = state.second[i] > WithMargin(state.best[i]);
    const int slot = state.slot[i];
    state.best[i] = kFarAway;
    Settle(points + lane, target, slot, state.best[i], state.slot[i]);
    if (certain) {
      continue;
    }
    if (state.seed[packet] >= 0) {
      SettleLeaf(points + lane, target, state.seed[packet], state.best[i], state.slot[i]);
    }
    for (int k = 0; k < leaf_count; ++k) {
      SettleLeaf(points + lane, target, static_cast<int>(leaves[k] & kNodeMask), state.best[i],
                 state.slot[i]);
    }
  }
}

/// PacketKernels::find without fused multiply-add.
template <class S>
void FindPlain(const QueryBlock& block,
               const PackedMesh::View& target,
               SearchSeed seed,
               const SearchQueues& queues,
               int32_t* slots,
               float* squared_distances) {
  BlockState state;
  SeedPlain<S>(block, target, seed, slots, state);
  uint32_t* in = queues.first;
  uint32_t* out = queues.second;
  const int listed = ListLeaves<S>(block, target, state, in, out);
  const int kept = FilterLeaves<S>(block, target, state, in, listed, out);
  for (int i = 0; i < kept; ++i) {
    const uint32_t packet = out[i] >> kPacketShift;
    MeasureLeafPlain<S>(block.points + packet * kPacketFloats, target,
                        static_cast<int>(out[i] & kNodeMask), packet, state);
  }
  int begin = 0;  // The queue is in the order of the packets.
  for (int u = 0; u < block.packets; ++u) {
    int end = begin;
    while (end < kept && out[end] >> kPacketShift == static_cast<uint32_t>(u)) {
      ++end;
    }
    SettlePacket(block.points + u * kPacketFloats, target, out + begin, end - begin,
                 static_cast<uint32_t>(u), state);
    begin = end;
  }
  for (int i = 0; i < block.packets * 16; ++i) {
    slots[i] = state.slot[i];
    squared_distances[i] = state.best[i];
  }
}

}  // namespace cohort
