#pragma once

#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/io/landmarks.h"

namespace cohort {

/// Landmarks from 3D Slicer's .fcsv: comments "# Markups fiducial file version = ...",
/// "# CoordinateSystem = LPS" and "# columns = id,x,y,z,...", then rows. Rows may have more fields
/// than columns are named; of those the first is the position's status (2: defined).
/// @return as ReadLandmarkTable.
[[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> ReadFcsv(std::string_view bytes,
                                                                  std::string_view file_name,
                                                                  const LandmarkLimits& limits);

}  // namespace cohort
