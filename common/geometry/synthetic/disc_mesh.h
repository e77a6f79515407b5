#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cohort {

/// Triangles of a disc with their neighbours: the connectivity under TriangulatePatch.
///
/// Face f has vertices v[0..2] counter-clockwise; side k runs from v[k] to v[(k + 1) % 3], and
/// next[k] is the face beyond it, -1 at the border. Not thread-safe.
class DiscMesh {
 public:
  struct Face {
    std::array<int32_t, 3> v;
    std::array<int32_t, 3> next;
  };

  /// A fan: vertex 0 in the middle, vertices 1..rim around it.
  explicit DiscMesh(int32_t rim);

  [[nodiscard]] const std::vector<Face>& Faces() const { return faces_; }
  [[nodiscard]] const Face& At(int32_t face) const { return faces_[static_cast<size_t>(face)]; }
  /// The side of `face` that runs from a to b, -1 if there is none.
  [[nodiscard]] int SideOf(int32_t face, int32_t a, int32_t b) const;

  /// Puts the next vertex on side k of `face`; its faces are added to `changed`.
  int32_t Split(int32_t face, int k, std::vector<int32_t>& changed);
  /// Replaces the edge at side k of `face`, which is no border, by the other diagonal.
  void Flip(int32_t face, int k);
  /// The faces around vertex v, counter-clockwise (from border to border on the rim).
  void FacesAround(int32_t v, std::vector<int32_t>& faces) const;

 private:
  Face& Mutable(int32_t face) { return faces_[static_cast<size_t>(face)]; }
  void Set(int32_t face, const Face& value);
  /// Tells face `at` that the face beyond it is now `now` instead of `before`.
  void Relink(int32_t at, int32_t before, int32_t now);

  std::vector<Face> faces_;
  std::vector<int32_t> face_of_;  // one face of each vertex
};

}  // namespace cohort
