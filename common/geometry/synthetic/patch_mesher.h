#pragma once

#include <cstddef>
#include <cstdint>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/base/random.h"
#include "common/geometry/synthetic/disc_mesh.h"
#include "common/geometry/synthetic/triangulate_patch.h"

namespace cohort {

/// A vertex of a patch being triangulated.
struct PatchVertex {
  Eigen::Vector2d uv;
  Eigen::Vector3d p;
  double edge_length = 1;  // wanted here, relative
  double t = -1;           // on the border curve; -1 inside
};

/// An edge to be split, the longest first.
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

/// The work behind TriangulatePatch and its state; used once. Not thread-safe.
class PatchMesher {
 public:
  PatchMesher(const SurfacePatch& patch, uint64_t seed)
      : patch_(patch), random_(seed), disc_(kRim) {}

  [[nodiscard]] TriangleMesh Run(int64_t vertex_count);

 private:
  [[nodiscard]] PatchVertex MakeVertex(const Eigen::Vector2d& uv, double t) const {
    return {uv, patch_.point(uv), patch_.edge_length(uv), t};
  }
  [[nodiscard]] const PatchVertex& At(int32_t v) const { return vertices_[static_cast<size_t>(v)]; }

  void PlaceFan();
  void Refine(int64_t vertex_count);
  PatchVertex NearMiddle(const LongEdge& edge);
  /// On the border curve; `opposite` is the third corner of the edge's face.
  PatchVertex NearMiddleOfBorder(const LongEdge& edge, int32_t opposite);
  void Push(int32_t a, int32_t b);
  /// The face with a side from a to b and that side, or {-1, -1}.
  std::pair<int32_t, int> FindSide(int32_t a, int32_t b);
  /// Flips what is better flipped at the faces on the stack and at those that flips change.
  void FlipFrom(std::vector<int32_t>& stack);
  void FlipAll();
  [[nodiscard]] bool ShouldFlip(int32_t face, int k) const;
  /// Slides every vertex towards the middle of its neighbours.
  void Smooth();
  [[nodiscard]] PatchVertex EvenedOut(int32_t v) const;
  /// Tries small random moves of the corners of triangles with a small angle.
  void Repair();
  /// Moves v unless that makes the smallest angle around it smaller and less than `enough` (sine).
  bool TryMove(int32_t v, const PatchVertex& moved, double enough);
  /// Whether a triangle of the parameter domain has too little area, or a negative one.
  static bool IsThin(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
  [[nodiscard]] TriangleMesh ToMesh() const;

  static constexpr int32_t kRim = 18;  // vertices of the first fan

  const SurfacePatch& patch_;
  Random random_;
  DiscMesh disc_;
  std::vector<PatchVertex> vertices_;
  std::priority_queue<LongEdge> queue_;  // of all edges, and of some that are gone
  bool refining_ = true;                 // flips queue their new edge
  std::vector<int32_t> around_;          // scratch of TryMove and Smooth
};

}  // namespace cohort
