#include "common/geometry/synthetic/triangulate_patch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "common/base/random.h"
#include "common/geometry/synthetic/disc_mesh.h"

namespace cohort {
namespace {

constexpr int32_t kRim = 18;  // vertices of the first fan
constexpr int kSmoothingPasses = 3;
constexpr int kRepairPasses = 4;
constexpr double kGoodAngle = 0.45;  // sine; above it a smoothing step may trade angles
constexpr double kPoorAngle = 0.40;  // sine; below it repair tries to do better
constexpr double kThinnest = 0.004;  // least (u, v) area of a triangle / longest side squared
constexpr double kSharpest = 0.2;    // least cosine between the faces of a flipped edge

size_t Index(int32_t i) {
  return static_cast<size_t>(i);
}

struct Vertex {
  Eigen::Vector2d uv;
  Eigen::Vector3d p;
  double edge_length = 1;  // wanted here, relative
  double t = -1;           // on the border curve; -1 inside
};

struct LongEdge {
  double length;
  int32_t a, b;
  /// Total, so that the order never depends on how a heap breaks ties.
  bool operator<(const LongEdge& other) const {
    if (length != other.length) {
      return length < other.length;
    }
    return a != other.a ? a < other.a : b < other.b;
  }
};

/// The refinement and its state; used once.
class PatchMesher {
 public:
  PatchMesher(const SurfacePatch& patch, uint64_t seed)
      : patch_(patch), random_(seed), disc_(kRim) {}

  TriangleMesh Run(int64_t vertex_count) {
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

 private:
  Vertex MakeVertex(const Eigen::Vector2d& uv, double t) const {
    return {uv, patch_.point(uv), patch_.edge_length(uv), t};
  }
  const Vertex& At(int32_t v) const { return vertices_[Index(v)]; }

  void PlaceFan();
  void Refine(int64_t vertex_count);
  Vertex NearMiddle(const LongEdge& edge, int32_t opposite, bool border);
  void Push(int32_t a, int32_t b);
  /// The face with a side from a to b and that side, or {-1, -1}.
  std::pair<int32_t, int> FindSide(int32_t a, int32_t b);
  /// Flips what is better flipped at the faces on the stack and at those that flips change.
  void FlipFrom(std::vector<int32_t>& stack);
  void FlipAll();
  bool ShouldFlip(int32_t face, int k) const;
  void Smooth();
  Vertex EvenedOut(int32_t v) const;
  void Repair();
  bool TryMove(int32_t v, const Vertex& moved, double enough);
  double Thinness(const Eigen::Vector2d& a,
                  const Eigen::Vector2d& b,
                  const Eigen::Vector2d& c) const;
  TriangleMesh ToMesh() const;

  const SurfacePatch& patch_;
  Random random_;
  DiscMesh disc_;
  std::vector<Vertex> vertices_;
  std::priority_queue<LongEdge> queue_;  // of all edges, and of some that are gone
  bool refining_ = true;                 // flips queue their new edge
  std::vector<int32_t> around_;          // scratch of TryMove and Smooth
};

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
    vertices_.push_back(NearMiddle(edge, opposite, border));
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

Vertex PatchMesher::NearMiddle(const LongEdge& edge, int32_t opposite, bool border) {
  const Vertex& a = At(edge.a);
  const Vertex& b = At(edge.b);
  const double share = random_.Uniform(0.36, 0.64);
  if (border) {
    const double step = b.t >= a.t ? b.t - a.t : b.t - a.t + 1.0;  // the curve runs from a to b
    const double sum = a.t + share * step;
    const double t = sum - std::floor(sum);
    const Eigen::Vector2d uv = patch_.border(t);
    const Eigen::Vector2d& c = At(opposite).uv;
    if (Thinness(a.uv, uv, c) > kThinnest && Thinness(uv, b.uv, c) > kThinnest) {
      return MakeVertex(uv, t);
    }
    return MakeVertex(a.uv + share * (b.uv - a.uv), t);  // the curve bends in too far
  }
  return MakeVertex(a.uv + share * (b.uv - a.uv), -1);
}

double PatchMesher::Thinness(const Eigen::Vector2d& a,
                             const Eigen::Vector2d& b,
                             const Eigen::Vector2d& c) const {
  const Eigen::Vector2d ab = b - a;
  const Eigen::Vector2d ac = c - a;
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  return (ab.x() * ac.y() - ab.y() * ac.x()) / longest;
}

bool PatchMesher::ShouldFlip(int32_t face, int k) const {
  const DiscMesh::Face& f = disc_.At(face);
  const int32_t across = f.next[static_cast<size_t>(k)];
  if (across < 0) {
    return false;
  }
  const int32_t ia = f.v[static_cast<size_t>(k)];
  const int32_t ib = f.v[static_cast<size_t>((k + 1) % 3)];
  const Vertex& a = At(ia);
  const Vertex& b = At(ib);
  const Vertex& c = At(f.v[static_cast<size_t>((k + 2) % 3)]);
  const int j = disc_.SideOf(across, ib, ia);
  const Vertex& d = At(disc_.At(across).v[static_cast<size_t>((j + 2) % 3)]);
  const double before =
      std::min(SineOfSmallestAngle(a.p, b.p, c.p), SineOfSmallestAngle(b.p, a.p, d.p));
  const double after =
      std::min(SineOfSmallestAngle(a.p, d.p, c.p), SineOfSmallestAngle(d.p, b.p, c.p));
  // The smallest angle grows with every flip, so there is an end to them.
  if (after <= before + 1e-9 || Thinness(a.uv, d.uv, c.uv) < kThinnest ||
      Thinness(d.uv, b.uv, c.uv) < kThinnest) {
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

bool PatchMesher::TryMove(int32_t v, const Vertex& moved, double enough) {
  disc_.FacesAround(v, around_);
  double before = 1;
  double after = 1;
  for (const int32_t face : around_) {
    const DiscMesh::Face& f = disc_.At(face);
    const size_t k = f.v[0] == v ? 0 : f.v[1] == v ? 1 : 2;
    const Vertex& b = At(f.v[(k + 1) % 3]);
    const Vertex& c = At(f.v[(k + 2) % 3]);
    if (Thinness(moved.uv, b.uv, c.uv) < kThinnest) {
      return false;
    }
    before = std::min(before, SineOfSmallestAngle(At(v).p, b.p, c.p));
    after = std::min(after, SineOfSmallestAngle(moved.p, b.p, c.p));
  }
  if (after <= before && after < enough) {
    return false;
  }
  vertices_[Index(v)] = moved;
  return true;
}

Vertex PatchMesher::EvenedOut(int32_t v) const {
  // Border vertices see their two neighbours on the border, others all: far ones pull more.
  const Vertex& here = At(v);
  double weight_sum = 0;
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  double t = 0;
  const auto pull = [&](const Vertex& other) {
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
      const Vertex& other = At(corners[static_cast<size_t>((attempt + 1) % 3)]);
      const Vertex& here = At(v);
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

}  // namespace

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
