#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

namespace cohort {

/// A mesh where its alignment put it, float32 bit by bit: with Arithmetic::kFidentis the next round
/// and the comparison go on from these numbers, which no similarity gives back exactly.
struct PlacedMesh {
  int32_t mesh = 0;           ///< Index in the job.
  Eigen::Matrix3Xf vertices;  ///< 3 x n, mesh units, in the order of the file.
};
/// "COHPLCD1", uint64 count, count x { int32 mesh, uint64 n, n x 3 float32 }.
/// @param meshes  ascending, each with vertices.
[[nodiscard]] std::string EncodePlacedBlob(const std::vector<PlacedMesh>& meshes);
/// @return kDataLoss, as of other blobs (blobs.h); also for a mesh without vertices, coordinates
///         that are not finite, or meshes that do not ascend.
[[nodiscard]] absl::StatusOr<std::vector<PlacedMesh>> DecodePlacedBlob(std::string_view bytes);

}  // namespace cohort
