#include "common/geometry/synthetic/triangulate_patch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "common/geometry/synthetic/disc_mesh.h"
#include "common/geometry/synthetic/patch_mesher.h"

namespace cohort {
namespace {

constexpr int kSmoothingPasses = 3;
constexpr int kRepairPasses = 4;
constexpr double kThinnest = 0.004;  // least (u, v) area of a triangle / longest side squared
constexpr double kLowShare = 0.36;   // where a split may lie on its edge
constexpr double kHighShare = 0.64;
constexpr double kSharpest = 0.2;  // least cosine between the faces of a flipped edge

}  // namespace

TriangleMesh PatchMesher::Run(int64_t vertex_count) {
  PlaceFan();
  Refine(vertex_count);
  refining_ = false;
  for (int pass = 0; pass < kSmoothingPasses; ++pass) {
    Smooth();
    FlipAll();
  }
  for (int pass = 0; pass < kRepairPasses; ++pass) {
    Repair();
    FlipAll();
  }
  return ToMesh();
}

void PatchMesher::PlaceFan() {
  vertices_.push_back(MakeVertex(patch_.border_center, -1));
  const double turn = random_.Uniform();
  for (int32_t i = 0; i < kRim; ++i) {
    double t = (i + turn + random_.Uniform(-0.2, 0.2)) / kRim;
    t -= std::floor(t);
    vertices_.push_back(MakeVertex(patch_.border(t), t));
  }
}

void PatchMesher::Push(int32_t a, int32_t b) {
  const double wanted = At(a).edge_length + At(b).edge_length;
  queue_.push({(At(a).p - At(b).p).norm() / wanted, a, b});
}

std::pair<int32_t, int> PatchMesher::FindSide(int32_t a, int32_t b) {
  disc_.FacesAround(a, around_);
  for (const int32_t face : around_) {
    if (const int k = disc_.SideOf(face, a, b); k >= 0) {
      return {face, k};
    }
  }
  return {-1, -1};
}

void PatchMesher::Refine(int64_t vertex_count) {
  vertices_.reserve(static_cast<size_t>(vertex_count));
  for (const DiscMesh::Face& f : disc_.Faces()) {
    Push(f.v[0], f.v[1]);
    Push(f.v[1], f.v[2]);
  }
  std::vector<int32_t> changed;
  while (static_cast<int64_t>(vertices_.size()) < vertex_count) {
    assert(!queue_.empty());  // every edge is in the queue
    const LongEdge edge = queue_.top();
    queue_.pop();
    const auto [face, k] = FindSide(edge.a, edge.b);
    if (face < 0) {
      continue;  // flipped away since it was queued
    }
    const int32_t opposite = disc_.At(face).v[static_cast<size_t>((k + 2) % 3)];
    const bool border = disc_.At(face).next[static_cast<size_t>(k)] < 0;
    vertices_.push_back(border ? NearMiddleOfBorder(edge, opposite) : NearMiddle(edge));
    changed.clear();
    const int32_t m = disc_.Split(face, k, changed);
    Push(edge.a, m);
    Push(m, edge.b);
    Push(m, opposite);
    if (!border) {
      Push(m, disc_.At(changed[2]).v[2]);  // the corner across
    }
    FlipFrom(changed);
  }
}

PatchVertex PatchMesher::NearMiddle(const LongEdge& edge) {
  const double share = random_.Uniform(kLowShare, kHighShare);
  return MakeVertex(At(edge.a).uv + share * (At(edge.b).uv - At(edge.a).uv), -1);
}

PatchVertex PatchMesher::NearMiddleOfBorder(const LongEdge& edge, int32_t opposite) {
  const PatchVertex& a = At(edge.a);
  const PatchVertex& b = At(edge.b);
  const double share = random_.Uniform(kLowShare, kHighShare);
  const double step = b.t >= a.t ? b.t - a.t : b.t - a.t + 1.0;  // the curve runs from a to b
  const double sum = a.t + share * step;
  const double t = sum - std::floor(sum);
  const Eigen::Vector2d uv = patch_.border(t);
  const Eigen::Vector2d& c = At(opposite).uv;
  if (!IsThin(a.uv, uv, c) && !IsThin(uv, b.uv, c)) {
    return MakeVertex(uv, t);
  }
  return MakeVertex(a.uv + share * (b.uv - a.uv), t);  // the curve bends in too far
}

bool PatchMesher::IsThin(const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b,
                         const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a;
  const Eigen::Vector2d ac = c - a;
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  return ab.x() * ac.y() - ab.y() * ac.x() < kThinnest * longest;
}

bool PatchMesher::ShouldFlip(int32_t face, int k) const {
  const DiscMesh::Face& f = disc_.At(face);
  const int32_t across = f.next[static_cast<size_t>(k)];
  if (across < 0) {
    return false;
  }
  const int32_t ia = f.v[static_cast<size_t>(k)];
  const int32_t ib = f.v[static_cast<size_t>((k + 1) % 3)];
  const PatchVertex& a = At(ia);
  const PatchVertex& b = At(ib);
  const PatchVertex& c = At(f.v[static_cast<size_t>((k + 2) % 3)]);
  const int j = disc_.SideOf(across, ib, ia);
  const PatchVertex& d = At(disc_.At(across).v[static_cast<size_t>((j + 2) % 3)]);
  const double before =
      std::min(SineOfSmallestAngle(a.p, b.p, c.p), SineOfSmallestAngle(b.p, a.p, d.p));
  const double after =
      std::min(SineOfSmallestAngle(a.p, d.p, c.p), SineOfSmallestAngle(d.p, b.p, c.p));
  // The smallest angle grows with every flip, so there is an end to them.
  if (after <= before + 1e-9 || IsThin(a.uv, d.uv, c.uv) || IsThin(d.uv, b.uv, c.uv)) {
    return false;
  }
  const Eigen::Vector3d n1 = (d.p - a.p).cross(c.p - a.p);
  const Eigen::Vector3d n2 = (b.p - d.p).cross(c.p - d.p);
  return n1.dot(n2) > kSharpest * n1.norm() * n2.norm();
}

void PatchMesher::FlipFrom(std::vector<int32_t>& stack) {
  while (!stack.empty()) {
    const int32_t face = stack.back();
    stack.pop_back();
    for (int k = 0; k < 3; ++k) {
      if (!ShouldFlip(face, k)) {
        continue;
      }
      const int32_t across = disc_.At(face).next[static_cast<size_t>(k)];
      disc_.Flip(face, k);
      if (refining_) {
        Push(disc_.At(face).v[1], disc_.At(face).v[2]);  // the new edge
      }
      stack.insert(stack.end(), {face, across});
      break;
    }
  }
}

void PatchMesher::FlipAll() {
  std::vector<int32_t> stack(disc_.Faces().size());
  std::iota(stack.rbegin(), stack.rend(), 0);
  FlipFrom(stack);
}

TriangleMesh PatchMesher::ToMesh() const {
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(vertices_.size()));
  for (size_t i = 0; i < vertices_.size(); ++i) {
    mesh.vertices.col(static_cast<Eigen::Index>(i)) = vertices_[i].p;
  }
  const std::vector<DiscMesh::Face>& faces = disc_.Faces();
  mesh.faces.resize(3, static_cast<Eigen::Index>(faces.size()));
  for (size_t i = 0; i < faces.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      mesh.faces(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) = faces[i].v[k];
    }
  }
  return mesh;
}

double SineOfSmallestAngle(const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) {
  // The smallest angle lies between the two longer sides.
  const double ab = (b - a).squaredNorm();
  const double bc = (c - b).squaredNorm();
  const double ca = (a - c).squaredNorm();
  const double shortest = std::min({ab, bc, ca});
  return shortest > 0 ? (b - a).cross(c - a).norm() / std::sqrt(ab * bc * ca / shortest) : 0.0;
}

TriangleMesh TriangulatePatch(const SurfacePatch& patch, int64_t vertex_count, uint64_t seed) {
  assert(vertex_count >= 64);
  return PatchMesher(patch, seed).Run(vertex_count);
}

}  // namespace cohort
