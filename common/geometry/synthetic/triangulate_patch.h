#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// A disc-shaped piece of a parametric surface. The functions must depend on their arguments only.
struct SurfacePatch {
  /// Surface point of parameters (u, v), mm. Seen from outside, u to v turns counter-clockwise.
  std::function<Eigen::Vector3d(const Eigen::Vector2d& uv)> point;
  /// The border in (u, v): closed, counter-clockwise, t in [0, 1); star-shaped around
  /// border_center.
  std::function<Eigen::Vector2d(double t)> border;
  Eigen::Vector2d border_center = Eigen::Vector2d::Zero();
  /// Relative edge length wanted around (u, v), > 0; small where detail is.
  std::function<double(const Eigen::Vector2d& uv)> edge_length;
};

/// Triangulates the patch at random: another seed gives another mesh of the same surface.
///
/// A fan over the border is refined by splitting the longest edge (measured in space, relative to
/// edge_length) near its middle until the count is reached; every split is followed by flips that
/// enlarge the smallest angle. Then vertices slide along the surface to even out the edges. In
/// (u, v) every triangle keeps a positive area, so the mesh is a manifold disc and oriented.
/// @param vertex_count  exactly so many vertices, at least 64.
/// Source: ours (Rivara 1984 for the splitting, Lawson 1977 for the flips).
[[nodiscard]] TriangleMesh TriangulatePatch(const SurfacePatch& patch,
                                            int64_t vertex_count,
                                            uint64_t seed);

/// Sine of the smallest angle of a triangle; 0 if it has no area.
[[nodiscard]] double SineOfSmallestAngle(const Eigen::Vector3d& a,
                                         const Eigen::Vector3d& b,
                                         const Eigen::Vector3d& c);

}  // namespace cohort
