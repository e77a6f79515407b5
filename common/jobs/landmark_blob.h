#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/landmark_set.h"

namespace cohort {

/// The landmarks of a job's meshes, by mesh name, in mesh file coordinates.
using LandmarkTable = std::map<std::string, LandmarkSet>;

/// "COHLAND1", uint64 names, each { uint64 size, bytes }; uint64 meshes, each { uint64 size, bytes
/// of the mesh name, uint64 k, k x uint32 place in the names, k x 3 float64 }. Names ascend, so
/// that equal tables have equal bytes. 28 bytes a landmark.
[[nodiscard]] std::string EncodeLandmarkBlob(const LandmarkTable& table);
/// @return kDataLoss as the other blobs (blobs.h), also for points that are not finite.
[[nodiscard]] absl::StatusOr<LandmarkTable> DecodeLandmarkBlob(std::string_view bytes);

/// Memory that the table holds, roughly.
[[nodiscard]] int64_t SizeOf(const LandmarkTable& table);

}  // namespace cohort
