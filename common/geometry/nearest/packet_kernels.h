#pragma once

#include <cstddef>
#include <cstdint>

#include "common/geometry/nearest/packet_search_kernels.h"

/// The kernels of packet search, written once over a set of 16 lanes and compiled once per
/// instruction set. These sources may use no inline function of another header: the linker would
/// keep one copy of it, perhaps one that the machine cannot run.
///
/// Search: packets of 16 neighbouring queries advance together, phase by phase, over flat queues of
/// (packet, node), so that no branch depends on the data but the lengths of the queues:
///   1. one descent per packet, to the box nearest to its middle, all packets interleaved;
///   2. that leaf gives each lane an upper bound;
///   3. level by level, boxes that are nearer to the packet's box than its largest bound;
///   4. of the leaves left, those that are nearer to some lane than its own bound;
///   5. 16 x 16 distances for each of them.
/// Boxes and points are measured by the same formula, and rounding keeps order: a box is never
/// farther than a point in it, so no margin is needed and equal distances are never missed.
/// Source: reference/performance.md section 1, candidate (e).
namespace cohort {

// What one packet takes in an array.
constexpr ptrdiff_t kPacketLanes = PackedMesh::kLanes;
constexpr ptrdiff_t kPacketFloats = 3 * kPacketLanes;
constexpr ptrdiff_t kPacketBoxFloats = 8;

constexpr float kFarAway = __builtin_huge_valf();

/// An entry of a queue: the packet in the upper 8 bits, the node in the lower 24.
constexpr uint32_t kPacketShift = 24;
constexpr uint32_t kNodeMask = 0xFFFFFF;

template <class S>
struct Lanes3 {
  typename S::F x, y, z;
};

template <class S>
inline Lanes3<S> LoadPoints(const float* points) {
  return {S::Load(points), S::Load(points + 16), S::Load(points + 32)};
}

/// Distance along one axis between intervals, 0 if they meet.
template <class S>
inline typename S::F Gap(typename S::F low_a,
                         typename S::F high_a,
                         typename S::F low_b,
                         typename S::F high_b) {
  return S::Max(S::Max(S::Sub(low_b, high_a), S::Sub(low_a, high_b)), S::Set(0));
}

/// Squared distances of the box [low, high] to the 16 boxes of a group.
template <class S>
inline typename S::F BoxToGroup(const Lanes3<S>& low, const Lanes3<S>& high, const float* group) {
  return S::SquaredNorm(Gap<S>(low.x, high.x, S::Load(group), S::Load(group + 48)),
                        Gap<S>(low.y, high.y, S::Load(group + 16), S::Load(group + 64)),
                        Gap<S>(low.z, high.z, S::Load(group + 32), S::Load(group + 80)));
}

/// Squared distances of 16 points to one box.
template <class S>
inline typename S::F PointsToBox(const Lanes3<S>& p, const float* box) {
  return S::SquaredNorm(Gap<S>(p.x, p.x, S::Set(box[0]), S::Set(box[3])),
                        Gap<S>(p.y, p.y, S::Set(box[1]), S::Set(box[4])),
                        Gap<S>(p.z, p.z, S::Set(box[2]), S::Set(box[5])));
}

/// Squared distances of 16 points to point j of a leaf.
template <class S>
inline typename S::F PointsToPoint(const Lanes3<S>& p, const float* leaf, int j) {
  return S::SquaredNorm(S::Sub(p.x, S::Set(leaf[j])), S::Sub(p.y, S::Set(leaf[16 + j])),
                        S::Sub(p.z, S::Set(leaf[32 + j])));
}

/// What the lanes of a block know so far.
struct alignas(64) BlockState {
  float best[kBlockPackets * 16];    ///< Squared distance to `slot`.
  int32_t slot[kBlockPackets * 16];  ///< Nearest so far.
  float limit[kBlockPackets * 16];   ///< The nearest is no farther (portable path: plain).
  float second[kBlockPackets * 16];  ///< Portable path: next best of another slot.
  float bound[kBlockPackets];        ///< Largest limit of the packet.
  int seed[kBlockPackets];           ///< Leaf visited already; -1: none.
};

template <class S>
inline void Descend(const QueryBlock& block, const PackedMesh::View& target, BlockState& state) {
  for (int u = 0; u < block.packets; ++u) {
    state.seed[u] = 0;
  }
  for (int level = target.level_count - 1; level >= 0; --level) {
    for (int u = 0; u < block.packets; ++u) {
      const float* box = block.boxes + u * kPacketBoxFloats;
      const Lanes3<S> middle = {S::Set(0.5F * (box[0] + box[3])), S::Set(0.5F * (box[1] + box[4])),
                                S::Set(0.5F * (box[2] + box[5]))};
      const int64_t group = state.seed[u];
      const typename S::F distance =
          BoxToGroup<S>(middle, middle, target.levels[level] + group * 96);
      const unsigned nearest = S::Bits(S::Equal(distance, S::Set(S::LeastOf(distance))));
      state.seed[u] = static_cast<int>(group) * 16 + __builtin_ctz(nearest);
    }
  }
}

/// Fills the queue with the leaves whose boxes are within the packets' bounds; their number.
template <class S>
inline int ListLeaves(const QueryBlock& block,
                      const PackedMesh::View& target,
                      const BlockState& state,
                      uint32_t*& in,
                      uint32_t*& out) {
  int count = block.packets;
  for (int u = 0; u < count; ++u) {
    in[u] = static_cast<uint32_t>(u) << kPacketShift;
  }
  for (int level = target.level_count - 1; level >= 0; --level) {
    const float* groups = target.levels[level];
    int listed = 0;
    for (int i = 0; i < count; ++i) {
      const uint32_t packet = in[i] >> kPacketShift;
      const uint32_t node = in[i] & kNodeMask;
      const float* box = block.boxes + packet * kPacketBoxFloats;
      const Lanes3<S> low = {S::Set(box[0]), S::Set(box[1]), S::Set(box[2])};
      const Lanes3<S> high = {S::Set(box[3]), S::Set(box[4]), S::Set(box[5])};
      const typename S::F distance = BoxToGroup<S>(low, high, groups + int64_t{node} * 96);
      listed += S::StoreLanes(out + listed, S::LessEqual(distance, S::Set(state.bound[packet])),
                              packet << kPacketShift | node * 16);
    }
    uint32_t* const last = in;
    in = out;
    out = last;
    count = listed;
  }
  return count;
}

/// Keeps of `in` the leaves that some lane of the packet may need; writes them to `out`.
template <class S>
inline int FilterLeaves(const QueryBlock& block,
                        const PackedMesh::View& target,
                        const BlockState& state,
                        const uint32_t* in,
                        int count,
                        uint32_t* out) {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    const uint32_t packet = in[i] >> kPacketShift;
    const uint32_t leaf = in[i] & kNodeMask;
    const Lanes3<S> points = LoadPoints<S>(block.points + packet * kPacketFloats);
    const typename S::F distance =
        PointsToBox<S>(points, target.boxes + int64_t{leaf} * kPacketBoxFloats);
    const bool reached =
        S::Any(S::LessEqual(distance, S::Load(state.limit + packet * kPacketLanes)));
    out[kept] = in[i];
    kept +=
        static_cast<int>(reached) & static_cast<int>(static_cast<int>(leaf) != state.seed[packet]);
  }
  return kept;
}

}  // namespace cohort
