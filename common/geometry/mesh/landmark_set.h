#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace cohort {

/// Named points on one mesh, in the order of their file. Names are unique and not empty.
struct LandmarkSet {
  std::vector<std::string> names;  ///< n names, UTF-8.
  Eigen::Matrix3Xd points;         ///< 3 x n, column i belongs to names[i], mesh units.

  [[nodiscard]] int64_t Count() const { return points.cols(); }
  /// Column of the landmark, -1 if there is none of that name.
  [[nodiscard]] int64_t IndexOf(std::string_view name) const;
};

/// Names that every one of the sets has, in bytewise order, so that the order of the sets does not
/// matter.
[[nodiscard]] std::vector<std::string> CommonLandmarks(std::span<const LandmarkSet> sets);

/// The points of these names, 3 x names.size(), in the order of `names`; the set has them all.
[[nodiscard]] Eigen::Matrix3Xd PointsOf(const LandmarkSet& set, std::span<const std::string> names);

}  // namespace cohort
