#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/report/render/camera.h"

namespace cohort {

/// From where all thumbnails of a set are seen.
struct ThumbnailView {
  Facing facing;
  Camera camera;
};

/// The front view of the shape that all meshes were aligned to.
/// @param reference  at least one vertex.
[[nodiscard]] ThumbnailView ViewOf(const TriangleMesh& reference);

/// A small picture (108 x 135 pixels, PNG in shades of grey) of a mesh in the frame of `view`, at
/// the same scale as all others; one that is not there (it was not aligned), or much larger or
/// smaller, fills its own picture.
/// @return kInvalidArgument if the mesh has no vertex; kInternal if cairo fails.
[[nodiscard]] absl::StatusOr<std::string> ThumbnailPng(const TriangleMesh& mesh,
                                                       const ThumbnailView& view);

}  // namespace cohort
