#include "common/report/render/thumbnail.h"

#include <algorithm>

#include "common/geometry/mesh/bounds.h"
#include "common/report/render/image.h"
#include "common/report/render/rasterizer.h"

namespace cohort {
namespace {

constexpr int kWidth = 108;
constexpr int kHeight = 135;
constexpr double kAspect = static_cast<double>(kWidth) / kHeight;
// A mesh may stick out of the picture by this share of its half, and must fill this share of it.
constexpr double kLargest = 1.25;
constexpr double kSmallest = 0.6;

bool Fits(const TriangleMesh& mesh, const Camera& camera) {
  const Bounds seen = BoundsOf(camera.Project(mesh.vertices));
  const double reach = std::max({-seen.low.x(), -seen.low.y(), seen.high.x(), seen.high.y()});
  const double extent = std::max(seen.high.x() - seen.low.x(), seen.high.y() - seen.low.y());
  return reach <= kLargest && extent >= 2 * kSmallest;
}

}  // namespace

ThumbnailView ViewOf(const TriangleMesh& reference) {
  const Facing facing = FacingOf(reference);
  return {facing, WithAspect(FitCamera(reference.vertices, facing, View::kFront), kAspect)};
}

absl::StatusOr<std::string> ThumbnailPng(const TriangleMesh& mesh, const ThumbnailView& view) {
  if (mesh.VertexCount() < 1) return absl::InvalidArgumentError("thumbnail: a mesh of no vertex");
  const Camera camera =
      Fits(mesh, view.camera)
          ? view.camera
          : WithAspect(FitCamera(mesh.vertices, view.facing, View::kFront), kAspect);
  return ImagePng(RenderMesh(mesh, {}, camera, {.width = kWidth, .height = kHeight}));
}

}  // namespace cohort
