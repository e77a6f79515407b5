#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/packed_mesh.h"

namespace cohort {

/// Which part of a job's reference (mean shape) counts: a weight >= 0 for each of its vertices.
struct RegionMask {
  PackedMesh reference;         ///< In the frame of the pairs.
  std::vector<double> weights;  ///< One per vertex of the reference.
};

/// Reads weights as text: one number per line, one line per vertex of `mean_shape.ply`.
/// @param file_name  for messages.
/// @return kInvalidArgument with file and line: not a number >= 0, not `vertices` of them, all 0.
[[nodiscard]] absl::StatusOr<std::vector<double>> ParseRegionWeights(const std::string& text,
                                                                     const std::string& file_name,
                                                                     int64_t vertices);

/// How much each vertex of a placed mesh counts, in slot order: the area that it stands for, the
/// weight of the nearest vertex of the region's reference, or the product of both.
/// @param mesh  what `placed` was packed from.
/// @param region  null: all of the mesh.
[[nodiscard]] std::vector<double> SlotWeights(const TriangleMesh& mesh,
                                              const PackedMesh& placed,
                                              bool by_area,
                                              const RegionMask* region);

}  // namespace cohort
