#pragma once

#include "common/geometry/nearest/packet_kernels.h"
#include "common/geometry/nearest/surface_kernels.h"

namespace cohort {

// The distance that counts, in double without fused multiply-add: the same bits everywhere. The
// corners of a triangle ascend, so that triangles which share an edge or a corner give exactly
// equal distances there, and the lowest face wins.
//
// These sources are compiled per instruction set: see packet_kernels.h for what they may use. R
// holds the registers of the set: kFloats lanes of F, kDoubles lanes of D.

/// Triangles that may be nearest to a query of the block, not settled yet.
struct alignas(64) FoundPairs {
  static constexpr int kMost = 2048;
  uint32_t slots[kMost + 16];   ///< Of the target.
  uint8_t queries[kMost + 16];  ///< 16 * packet + lane.
  int count;
};
static_assert(kBlockPackets * 16 <= 256);

/// What is settled for one query so far.
struct alignas(32) Settled {
  double squared_distance;
  int32_t face;
  int32_t slot;
  float point[3];
};

/// For each query of a block; the last is a place for what loses.
struct SettledQueries {
  static constexpr int kLost = kBlockPackets * 16;
  Settled queries[kLost + 1];
};

template <class R>
struct Double3 {
  typename R::D x, y, z;
};

template <class R>
inline Double3<R> Sub(const Double3<R>& a, const Double3<R>& b) {
  return {R::SubD(a.x, b.x), R::SubD(a.y, b.y), R::SubD(a.z, b.z)};
}
template <class R>
inline Double3<R> Scale(const Double3<R>& a, typename R::D factor) {
  return {R::MulD(a.x, factor), R::MulD(a.y, factor), R::MulD(a.z, factor)};
}
template <class R>
inline typename R::D Dot(const Double3<R>& a, const Double3<R>& b) {
  return R::AddD(R::MulD(a.x, b.x), R::AddD(R::MulD(a.y, b.y), R::MulD(a.z, b.z)));
}
template <class R>
inline Double3<R> Cross(const Double3<R>& a, const Double3<R>& b) {
  return {R::SubD(R::MulD(a.y, b.z), R::MulD(a.z, b.y)),
          R::SubD(R::MulD(a.z, b.x), R::MulD(a.x, b.z)),
          R::SubD(R::MulD(a.x, b.y), R::MulD(a.y, b.x))};
}

/// Sixteen pairs, coordinates in rows: query (3), corners a, b, c (3 each).
struct alignas(64) PairRows {
  float rows[12][16];
  int32_t faces[16];
};

/// From the nearest point to the query, and its squared length.
template <class R>
struct Offset {
  Double3<R> vector;
  typename R::D squared_length;

  explicit Offset(const Double3<R>& v) : vector(v), squared_length(Dot<R>(v, v)) {}
  /// Takes the other where `mask` is set.
  void TakeWhere(typename R::MaskD mask, const Offset& other) {
    vector = {R::SelectD(mask, other.vector.x, vector.x),
              R::SelectD(mask, other.vector.y, vector.y),
              R::SelectD(mask, other.vector.z, vector.z)};
    squared_length = R::SelectD(mask, other.squared_length, squared_length);
  }
  void TakeIfNearer(const Offset& other) {
    TakeWhere(R::LessD(other.squared_length, squared_length), other);
  }
};

/// @param p  the query minus the edge's first end.
template <class R>
inline Offset<R> FromEdge(const Double3<R>& p, const Double3<R>& edge) {
  // An edge without length gives 0 / 0; MaxD then yields its second operand.
  const typename R::D along = R::DivD(Dot<R>(p, edge), Dot<R>(edge, edge));
  const typename R::D t = R::MinD(R::MaxD(along, R::SetD(0)), R::SetD(1));
  return Offset<R>(Sub<R>(p, Scale<R>(edge, t)));
}

/// Nearest point of the triangle: the foot on its plane if that is inside, by the signed areas that
/// it cuts off, or else on the nearest edge. Source: Eberly, Geometric Tools; signed areas as in
/// Ericson 2005, sec. 5.1.5.
template <class R>
inline Offset<R> FromTriangle(const Double3<R>& query,
                              const Double3<R>& a,
                              const Double3<R>& b,
                              const Double3<R>& c) {
  const Double3<R> p = Sub<R>(query, a);
  const Double3<R> ab = Sub<R>(b, a);
  const Double3<R> ac = Sub<R>(c, a);
  Offset<R> offset = FromEdge<R>(p, ab);
  offset.TakeIfNearer(FromEdge<R>(p, ac));
  offset.TakeIfNearer(FromEdge<R>(Sub<R>(query, b), Sub<R>(c, b)));
  const Double3<R> normal = Cross<R>(ab, ac);
  const typename R::D whole = Dot<R>(normal, normal);
  const typename R::D at_c = Dot<R>(Cross<R>(ab, p), normal);
  const typename R::D at_b = Dot<R>(Cross<R>(p, ac), normal);
  const typename R::D at_a = R::SubD(whole, R::AddD(at_b, at_c));
  const typename R::D least = R::MinD(at_a, R::MinD(at_b, at_c));
  const Offset<R> foot(Scale<R>(normal, R::DivD(Dot<R>(p, normal), whole)));
  offset.TakeWhere(R::LessD(R::SetD(0), least), foot);
  return offset;
}

/// Of sixteen pairs, in rows.
struct alignas(64) PairResults {
  double squared_distance[16];
  float point[3][16];
};

template <class R>
inline void MeasurePairs(const PairRows& pairs, PairResults& results) {
  for (int i = 0; i < 16; i += R::kDoubles) {
    const auto load = [&pairs, i](int row) {
      return Double3<R>{R::LoadFloats(pairs.rows[row] + i), R::LoadFloats(pairs.rows[row + 1] + i),
                        R::LoadFloats(pairs.rows[row + 2] + i)};
    };
    const Double3<R> query = load(0);
    const Offset<R> offset = FromTriangle<R>(query, load(3), load(6), load(9));
    const Double3<R> nearest = Sub<R>(query, offset.vector);
    R::StoreD(results.squared_distance + i, offset.squared_length);
    R::StoreRounded(results.point[0] + i, nearest.x);
    R::StoreRounded(results.point[1] + i, nearest.y);
    R::StoreRounded(results.point[2] + i, nearest.z);
  }
}

/// Gathers the pairs from `first` on; the last again where there are not sixteen.
template <class R>
inline void GatherPairs(const float* points,
                        const PackedSurface::View& target,
                        const FoundPairs& found,
                        int first,
                        PairRows& pairs) {
  for (int i = 0; i < 16; ++i) {
    const int at = first + i < found.count ? first + i : found.count - 1;
    const float* corners = target.corners + int64_t{found.slots[at]} * PackedSurface::kCornerFloats;
    const int query = found.queries[at];
    const float* point = points + int64_t{query / 16} * kPacketFloats + query % 16;
    for (int64_t side = 0; side < 3; ++side) {
      pairs.rows[side][i] = point[16 * side];
    }
    for (int k = 0; k < 9; ++k) {
      pairs.rows[3 + k][i] = corners[k];
    }
    __builtin_memcpy(&pairs.faces[i], corners + 9, sizeof(int32_t));
  }
}

/// Fetches the corners of sixteen pairs that come later: they are spread over the memory.
template <class R>
inline void FetchCorners(const PackedSurface::View& target, const FoundPairs& found, int first) {
  for (int i = first; i < first + 16 && i < found.count; ++i) {
    const float* corners = target.corners + int64_t{found.slots[i]} * PackedSurface::kCornerFloats;
    __builtin_prefetch(corners);
    __builtin_prefetch(corners + PackedSurface::kCornerFloats - 1);
  }
}

/// Measures the pairs and keeps for each query what is nearest, or as near and of a lower face.
template <class R>
inline void SettlePairs(const float* points,
                        const PackedSurface::View& target,
                        FoundPairs& found,
                        SettledQueries& settled) {
  FetchCorners<R>(target, found, 0);
  for (int first = 0; first < found.count; first += 16) {
    FetchCorners<R>(target, found, first + 16);
    PairRows pairs;
    PairResults results;
    GatherPairs<R>(points, target, found, first, pairs);
    MeasurePairs<R>(pairs, results);
    const int count = found.count - first < 16 ? found.count - first : 16;
    for (int i = 0; i < count; ++i) {
      const int query = found.queries[first + i];
      const double distance = results.squared_distance[i];
      const Settled& old = settled.queries[query];
      const bool tied = distance == old.squared_distance;
      const bool won = (distance < old.squared_distance) | (tied & (pairs.faces[i] < old.face));
      // Nobody could predict a branch here.
      const int to =
          SettledQueries::kLost + static_cast<int>(won) * (query - SettledQueries::kLost);
      settled.queries[to] = {
          .squared_distance = distance,
          .face = pairs.faces[i],
          .slot = static_cast<int32_t>(found.slots[first + i]),
          .point = {results.point[0][i], results.point[1][i], results.point[2][i]}};
    }
  }
  found.count = 0;
}

}  // namespace cohort
