#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/jobs/blobs.h"

namespace cohort {

/// The RMS distance of each vertex to all meshes on the shape, from three views (PNG), with the
/// colours of VariationPly.
/// @return as ShapeViewsPng.
[[nodiscard]] absl::StatusOr<std::string> VariationPng(const TriangleMesh& shape,
                                                       const VariationSummary& summary);

}  // namespace cohort
