// How PatchMesher evens out the triangles once all vertices are there.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "common/geometry/synthetic/patch_mesher.h"

namespace cohort {
namespace {

constexpr double kGoodAngle = 0.45;  // sine; above it a smoothing step may trade angles
constexpr double kPoorAngle = 0.40;  // sine; below it repair tries to do better

}  // namespace

bool PatchMesher::TryMove(int32_t v, const PatchVertex& moved, double enough) {
  disc_.FacesAround(v, around_);
  double before = 1;
  double after = 1;
  for (const int32_t face : around_) {
    const DiscMesh::Face& f = disc_.At(face);
    const size_t k = f.v[0] == v ? 0 : f.v[1] == v ? 1 : 2;
    const PatchVertex& b = At(f.v[(k + 1) % 3]);
    const PatchVertex& c = At(f.v[(k + 2) % 3]);
    if (IsThin(moved.uv, b.uv, c.uv)) {
      return false;
    }
    before = std::min(before, SineOfSmallestAngle(At(v).p, b.p, c.p));
    after = std::min(after, SineOfSmallestAngle(moved.p, b.p, c.p));
  }
  if (after <= before && after < enough) {
    return false;
  }
  vertices_[static_cast<size_t>(v)] = moved;
  return true;
}

PatchVertex PatchMesher::EvenedOut(int32_t v) const {
  // Border vertices see their two neighbours on the border, others all: far ones pull more.
  const PatchVertex& here = At(v);
  double weight_sum = 0;
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  double t = 0;
  const auto pull = [&](const PatchVertex& other) {
    const double weight = (other.p - here.p).norm() / (other.edge_length + here.edge_length);
    const double step = other.t - here.t;
    weight_sum += weight;
    uv += weight * (other.uv - here.uv);
    t += weight * (step - std::floor(step + 0.5));
  };
  for (const int32_t face : around_) {
    const DiscMesh::Face& f = disc_.At(face);
    const size_t k = f.v[0] == v ? 0 : f.v[1] == v ? 1 : 2;
    if (here.t < 0 || f.next[k] < 0) {
      pull(At(f.v[(k + 1) % 3]));
    }
    if (here.t >= 0 && f.next[(k + 2) % 3] < 0) {
      pull(At(f.v[(k + 2) % 3]));
    }
  }
  if (here.t < 0) {
    return MakeVertex(here.uv + 0.7 * uv / weight_sum, -1);
  }
  const double moved = here.t + 0.5 * t / weight_sum;
  const double wrapped = moved - std::floor(moved);
  return MakeVertex(patch_.border(wrapped), wrapped);
}

void PatchMesher::Smooth() {
  for (int32_t v = 0; v < static_cast<int32_t>(vertices_.size()); ++v) {
    disc_.FacesAround(v, around_);
    TryMove(v, EvenedOut(v), kGoodAngle);
  }
}

void PatchMesher::Repair() {
  for (size_t face = 0; face < disc_.Faces().size(); ++face) {
    const std::array<int32_t, 3> corners = disc_.Faces()[face].v;
    const auto angle = [&] {
      return SineOfSmallestAngle(At(corners[0]).p, At(corners[1]).p, At(corners[2]).p);
    };
    for (int attempt = 0; attempt < 24 && angle() < kPoorAngle; ++attempt) {
      const int32_t v = corners[static_cast<size_t>(attempt % 3)];
      const PatchVertex& other = At(corners[static_cast<size_t>((attempt + 1) % 3)]);
      const PatchVertex& here = At(v);
      const double reach = 0.4 * (other.uv - here.uv).norm();
      if (here.t < 0) {
        const double du = random_.Uniform(-reach, reach);  // one by one: arguments have no order
        const double dv = random_.Uniform(-reach, reach);
        TryMove(v, MakeVertex(here.uv + Eigen::Vector2d(du, dv), -1), 1.0);
      } else {
        const double moved = here.t + random_.Uniform(-reach, reach) / 600.0;  // mm of border
        const double t = moved - std::floor(moved);
        TryMove(v, MakeVertex(patch_.border(t), t), 1.0);
      }
    }
  }
}

}  // namespace cohort
