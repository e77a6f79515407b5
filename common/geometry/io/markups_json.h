#pragma once

#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/io/landmarks.h"

namespace cohort {

/// Landmarks from 3D Slicer's markups (.mrk.json): the control points of all its lists.
/// Units other than mm are refused: Slicer measures its meshes in mm.
/// @return as ReadLandmarkTable.
[[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> ReadMarkupsJson(
    std::string_view bytes, std::string_view file_name, const LandmarkLimits& limits);

}  // namespace cohort
