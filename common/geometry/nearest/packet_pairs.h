#pragma once

#include "common/geometry/nearest/packet_kernels.h"

namespace cohort {

// Sums run in double over products of floats, which are exact there, and every lane adds its
// packets in order: no fused multiply-add, same bytes on every path.

/// PacketKernels::move.
template <class S>
void Move(const float* points,
          int packets,
          const PointTransform& transform,
          float* moved_points,
          float* moved_boxes) {
  for (int u = 0; u < packets; ++u) {
    const Lanes3<S> p = LoadPoints<S>(points + u * kPacketFloats);
    const typename S::D x = S::ToDouble(p.x);
    const typename S::D y = S::ToDouble(p.y);
    const typename S::D z = S::ToDouble(p.z);
    float* moved = moved_points + u * kPacketFloats;
    float* box = moved_boxes + u * kPacketBoxFloats;
    for (int side = 0; side < 3; ++side) {
      const double* row = transform.rows[side];
      const typename S::F value =
          S::ToFloat(S::AddD(S::MulD(S::SetD(row[0]), x),
                             S::AddD(S::MulD(S::SetD(row[1]), y),
                                     S::AddD(S::MulD(S::SetD(row[2]), z), S::SetD(row[3])))));
      S::Store(moved + kPacketLanes * side, value);
      box[side] = S::LeastOf(value);
      box[3 + side] = S::GreatestOf(value);
    }
  }
}

/// Doubles of one packet's lanes, 0 in those left out.
template <class S>
inline typename S::D Kept(typename S::F values, unsigned kept) {
  return S::ToDouble(kept == 0xFFFF ? values : S::Select(S::FromBits(kept), values, S::Set(0)));
}

/// sums.lanes[first + i] += values[i].
template <class S, int N>
struct Accumulators {
  typename S::D sums[N];
  Accumulators(const PairSumLanes& from, int first) {
    for (int i = 0; i < N; ++i) {
      sums[i] = S::LoadD(from.lanes[first + i]);
    }
  }
  void Add(int i, typename S::D value) { sums[i] = S::AddD(sums[i], value); }
  void Store(PairSumLanes& to, int first) const {
    for (int i = 0; i < N; ++i) {
      S::StoreD(to.lanes[first + i], sums[i]);
    }
  }
};

/// Target points of a block, gathered once; 0 in lanes left out.
template <class S>
struct Partners {
  alignas(64) float points[kBlockPackets * kPacketFloats];

  Partners(const PairBlock& block, const PackedMesh::View& target) {
    for (int u = 0; u < block.packets; ++u) {
      const typename S::I slots = S::LoadI(block.slots + u * kPacketLanes);
      for (int side = 0; side < 3; ++side) {
        S::Store(points + u * kPacketFloats + kPacketLanes * side,
                 S::GatherPoints(target.points, slots, side));
      }
    }
  }
};

template <class S>
inline void AddPoints(const PairBlock& block, const Partners<S>& partners, PairSumLanes& sums) {
  Accumulators<S, 10> to(sums, 0);
  for (int u = 0; u < block.packets; ++u) {
    const unsigned kept = block.kept[u];
    typename S::D squares_a = S::SetD(0);
    typename S::D squares_b = S::SetD(0);
    for (int side = 0; side < 3; ++side) {
      const ptrdiff_t at = u * kPacketFloats + kPacketLanes * side;
      const typename S::D a = Kept<S>(S::Load(block.points + at), kept);
      const typename S::D b = Kept<S>(S::Load(partners.points + at), kept);
      to.Add(side, a);
      to.Add(3 + side, b);
      squares_a = S::AddD(squares_a, S::MulD(a, a));
      squares_b = S::AddD(squares_b, S::MulD(b, b));
    }
    to.Add(6, squares_a);
    to.Add(7, squares_b);
    const typename S::F squared = S::Load(block.squared_distances + u * kPacketLanes);
    to.Add(8, Kept<S>(squared, kept));
    to.Add(9, Kept<S>(S::Sqrt(squared), kept));
  }
  to.Store(sums, 0);
}

template <class S>
inline void AddProducts(const PairBlock& block,
                        const Partners<S>& partners,
                        int side,
                        PairSumLanes& sums) {
  Accumulators<S, 3> to(sums, 10 + 3 * side);
  for (int u = 0; u < block.packets; ++u) {
    const unsigned kept = block.kept[u];
    const float* points = block.points + u * kPacketFloats;
    const typename S::D b =
        Kept<S>(S::Load(partners.points + u * kPacketFloats + kPacketLanes * side), kept);
    for (int i = 0; i < 3; ++i) {
      to.Add(i, S::MulD(b, S::ToDouble(S::Load(points + kPacketLanes * i))));
    }
  }
  to.Store(sums, 10 + 3 * side);
}

/// PacketKernels::add_pairs.
template <class S>
void AddPairs(const PairBlock& block, const PackedMesh::View& target, PairSumLanes& sums) {
  const Partners<S> partners(block, target);
  AddPoints<S>(block, partners, sums);
  for (int side = 0; side < 3; ++side) {
    AddProducts<S>(block, partners, side, sums);
  }
}

}  // namespace cohort
