#pragma once

#include <span>
#include <vector>

#include <absl/status/statusor.h>

#include "client/session.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/jobs/blobs.h"

namespace cohort {

/// RMS distance of nearest vertices, mean of both directions; the shapes as they lie.
[[nodiscard]] double ShapeDistance(const TriangleMesh& a, const TriangleMesh& b);

/// `a` moved onto `b` by coarse pose and converged ICP.
/// @return as FindCoarsePose and AlignByIcp.
[[nodiscard]] absl::StatusOr<TriangleMesh> MovedOnto(const TriangleMesh& a, const TriangleMesh& b);

/// A mean shape with the RMS of the distances of each of its vertices to all meshes.
struct VariationMap {
  TriangleMesh shape;
  std::vector<double> rms;  ///< One per vertex.
};
[[nodiscard]] absl::StatusOr<VariationMap> FetchVariation(Session& session, const JobId& job);

/// Values of `map` at the nearest vertices of another shape in the same frame.
[[nodiscard]] std::vector<double> ValuesAt(const VariationMap& map, const TriangleMesh& shape);

/// Spearman's correlation (ties get the mean rank); NaN if one is constant.
[[nodiscard]] double RankCorrelation(std::span<const double> a, std::span<const double> b);

/// Share of the positions of the largest tenth of `a` that are in that of `b`.
[[nodiscard]] double TopTenthOverlap(std::span<const double> a, std::span<const double> b);

}  // namespace cohort
