#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <absl/status/status.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/nearest_vertex.h"

namespace cohort {

/// Distances and metrics as the predecessor, FIDENTIS Analyst of 2016, computes them: float32,
/// added in vertex order. From its own aligned meshes they come out equal to the last bit.
/// Source: reference c7, c8 and (f).

/// Normal of each vertex, 3 x n: the plain mean of the unit normals of its faces. NaN where a
/// vertex has no face or one without area; the distances of such a vertex are NaN, and with them
/// all metrics of the mesh.
///
/// The predecessor uses it, on the aligned mesh, only where the file has fewer normals (vn) than
/// vertices; else those of the file, as they were before the alignment.
/// @param vertices  3 x n, mesh units.
/// @param faces  indices below n.
[[nodiscard]] Eigen::Matrix3Xf FidentisNormals(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                                               const Matrix3Xi& faces);

/// Distance of each vertex p to its nearest target vertex c, times the sign of (p - c) . normal of
/// p: positive in front of the target, 0 where the product is. n values, mesh units.
/// @param vertices, normals  3 x n of the compared mesh (row of the matrix).
/// @param target  the main mesh (column), in the same frame.
[[nodiscard]] std::vector<float> FidentisSignedDistances(
    const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
    const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
    const NearestVertex& target);

/// The values without their signs. The predecessor stores signed distances and takes the absolute
/// ones from them, so that a distance whose sign is 0 is 0 here too.
[[nodiscard]] std::vector<float> FidentisAbsolute(std::span<const float> signed_distances);

/// Shares of the sorted values, 0 to 1.
struct FidentisThresholds {
  double lower = 0;
  double upper = 1;
  /// @return kInvalidArgument if one is not within 0..1.
  [[nodiscard]] absl::Status Validate() const;
};

/// The n values within the thresholds.
///
/// All of them, in their order, from 0 to 1; the single value 0 if upper <= lower; else the sorted
/// values from place trunc(n lower - 0.5) up to and without trunc(n upper - 0.5): upper = 1 with
/// lower > 0 loses the largest. May be empty.
[[nodiscard]] std::vector<float> FidentisWindow(std::span<const float> values,
                                                const FidentisThresholds& thresholds);

/// Indexed by the first seven of Metric, which are the predecessor's in the order of its menu.
inline constexpr int kFidentisMetricCount = 7;
using FidentisMetricValues = std::array<float, kFidentisMetricCount>;

/// All metrics of n signed or absolute distances; NaN, all of them, if a value is NaN or there is
/// none.
///
/// RMS and mean as anywhere. Geometric mean: product of the n-th roots; 0 with any 0, NaN with any
/// negative. Minimum and maximum: algebraic if signed. Variance: divided by n; 0 if the mean is 0.
/// P75: |sorted[trunc(0.75 n - 0.5)]|, sorted with their signs.
[[nodiscard]] FidentisMetricValues ComputeFidentisMetrics(std::span<const float> values);

/// (m + m^T) / 2 of an N x N matrix of any metric: the predecessor's "symmetric" export.
[[nodiscard]] Eigen::MatrixXf FidentisSymmetric(const Eigen::Ref<const Eigen::MatrixXf>& matrix);

}  // namespace cohort
