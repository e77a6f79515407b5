#pragma once

#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/io/landmarks.h"

namespace cohort {

/// Landmarks from MeshLab's PickedPoints (.pp): XML with
/// <PickedPoints> ... <point x="" y="" z="" name="" active=""/> ... </PickedPoints>.
/// @return as ReadLandmarkTable.
[[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> ReadPickedPoints(
    std::string_view bytes, std::string_view file_name, const LandmarkLimits& limits);

}  // namespace cohort
