#pragma once

#include "common/geometry/nearest/packet_kernels.h"
#include "common/geometry/nearest/surface_kernels.h"

namespace cohort {

// The float32 half of surface search, see surface_kernels_find.h: points against triangles and
// turned boxes, and how far that may be off.

/// Share of (distance + 2 * reach) by which a distance in float32 may be off: the frames, boxes and
/// products are rounded some 30 times.
constexpr float kRounding = 4e-6F;
/// The same where squares leave the normal numbers, and what the frames leave out as too short.
constexpr float kLeastDistance = 8e-18F;

/// Squared distances in float32 of one query to the 16 triangles of a leaf.
struct alignas(64) DistanceRow {
  float distances[16];
};

/// Squared distances that a nearest triangle may have in float32 where `squared` is the least, or
/// that a box around it may have.
template <class S>
inline typename S::F WithRounding(typename S::F squared, const PackedSurface::View& target) {
  const typename S::F distance = S::MulAdd(S::Sqrt(squared), S::Set(1 + 2 * kRounding),
                                           S::Set(4 * kRounding * target.reach + kLeastDistance));
  return S::Mul(distance, distance);
}

template <class R>
inline const float* PointsOfPacket(const QueryBlock& block, int packet) {
  return block.points + int64_t{packet} * kPacketFloats;
}

template <class R>
inline const float* FramesOfLeaf(const PackedSurface::View& target, int64_t leaf) {
  constexpr int64_t kFloats = int64_t{PackedSurface::kFrameRows} * 16;
  return target.frames + leaf * kFloats;
}

/// Squared distances of point `lane` of a packet to the 16 triangles of a leaf: see
/// PackedSurface::View::frames.
template <class R>
inline void MeasureTriangles(const float* points,
                             uint32_t lane,
                             const float* frames,
                             DistanceRow& row) {
  using F = typename R::F;
  const F zero = R::Set(0);
  const F one = R::Set(1);
  for (int64_t i = 0; i < 16; i += R::kFloats) {
    const auto load = [frames, i](int64_t r) { return R::Load(frames + 16 * r + i); };
    const F px = R::Sub(R::Set(points[lane]), load(0));
    const F py = R::Sub(R::Set(points[16 + lane]), load(1));
    const F pz = R::Sub(R::Set(points[32 + lane]), load(2));
    const F u = R::MulAdd(px, load(3), R::MulAdd(py, load(4), R::Mul(pz, load(5))));
    const F v = R::MulAdd(px, load(6), R::MulAdd(py, load(7), R::Mul(pz, load(8))));
    const F w = R::MulAdd(px, load(9), R::MulAdd(py, load(10), R::Mul(pz, load(11))));
    const F length = load(12);
    const F third = load(13);
    const F height = load(14);
    // P to Q, along the first axis.
    const F beside = R::Sub(u, R::Min(R::Max(u, zero), length));
    F nearest = R::MulAdd(beside, beside, R::Mul(v, v));
    // Q to R.
    const F uq = R::Sub(u, length);
    const F edge = R::Sub(third, length);
    F t = R::Mul(R::MulAdd(uq, edge, R::Mul(v, height)), load(15));
    t = R::Min(R::Max(t, zero), one);
    F du = R::NegMulAdd(t, edge, uq);
    F dv = R::NegMulAdd(t, height, v);
    nearest = R::Min(nearest, R::MulAdd(du, du, R::Mul(dv, dv)));
    // P to R.
    t = R::Mul(R::MulAdd(u, third, R::Mul(v, height)), load(16));
    t = R::Min(R::Max(t, zero), one);
    du = R::NegMulAdd(t, third, u);
    dv = R::NegMulAdd(t, height, v);
    nearest = R::Min(nearest, R::MulAdd(du, du, R::Mul(dv, dv)));
    // 0 inside: left of all three edges.
    const F left_of_qr = R::NegMulAdd(height, uq, R::Mul(edge, v));
    const F left_of_rp = R::NegMulAdd(third, v, R::Mul(height, u));
    nearest = R::ZeroWherePositive(R::Min(v, R::Min(left_of_qr, left_of_rp)), nearest);
    R::Store(row.distances + i, R::MulAdd(w, w, nearest));
  }
}

/// Squared distances of 16 points to a turned box.
template <class S>
inline typename S::F PointsToTurnedBox(const Lanes3<S>& p, const float* box) {
  const Lanes3<S> d = {S::Sub(p.x, S::Set(box[0])), S::Sub(p.y, S::Set(box[1])),
                       S::Sub(p.z, S::Set(box[2]))};
  const auto gap = [&d, box](int64_t side) {
    const float* axis = box + 3 + 3 * side;
    const typename S::F at = S::MulAdd(
        d.x, S::Set(axis[0]), S::MulAdd(d.y, S::Set(axis[1]), S::Mul(d.z, S::Set(axis[2]))));
    return Gap<S>(at, at, S::Set(-box[12 + side]), S::Set(box[12 + side]));
  };
  return S::SquaredNorm(gap(0), gap(1), gap(2));
}

}  // namespace cohort
