#pragma once

#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/io/landmarks.h"

namespace cohort {

/// Landmarks from a table with a header row (ReadLandmarkTable says which columns).
/// @return as ReadLandmarkTable.
[[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> ReadLandmarkCsv(
    std::string_view bytes, std::string_view file_name, const LandmarkLimits& limits);

}  // namespace cohort
