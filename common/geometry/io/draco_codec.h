#pragma once

#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

struct DracoOptions {
  /// 8..30; error <= half a step = longest box side / (2^bits - 1) / 2, and float32 rounding.
  int position_bits = 18;
  [[nodiscard]] absl::Status Validate() const;
};

/// Compresses a mesh that passed CheckAndClean (edgebreaker; sequential where that fails; points).
/// Vertex order and count may change: what DecodeDraco gives back is the mesh from then on.
/// @return kInvalidArgument for an empty mesh, kInternal with Draco's words.
[[nodiscard]] absl::StatusOr<std::string> EncodeDraco(const TriangleMesh& mesh,
                                                      const DracoOptions& options = {});

/// @return kDataLoss if the bytes are not a Draco mesh or cloud, or hold indices out of range,
///         values that are not finite, or counts beyond `max_vertices`.
[[nodiscard]] absl::StatusOr<TriangleMesh> DecodeDraco(std::string_view bytes,
                                                       int64_t max_vertices = 20'000'000);

}  // namespace cohort
