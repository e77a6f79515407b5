#pragma once

#include <span>
#include <string>

#include <absl/status/statusor.h>

namespace cohort {

/// Distances of one direction of a pair.
struct DistanceSeries {
  std::string name;                  ///< "a.ply to b.ply".
  std::span<const float> distances;  ///< Mesh units; NaN does not count.
};

/// Distribution of the distances of a pair (PNG), as shares of the vertices of each direction, so
/// that meshes of different density can be compared. Medians are dashed lines.
/// @param there, back  the two directions.
/// @param axis_title  with the unit.
/// @return kInternal if cairo fails.
[[nodiscard]] absl::StatusOr<std::string> DistanceHistogramPng(const DistanceSeries& there,
                                                               const DistanceSeries& back,
                                                               const std::string& title,
                                                               const std::string& axis_title);

}  // namespace cohort
