#pragma once

#include <span>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/report/color_map.h"
#include "common/report/render/camera.h"
#include "common/report/render/image.h"

namespace cohort {

/// Of surfaces without colours: plaster.
inline constexpr Rgb kPlasterColor = {214, 214, 214};

struct RenderOptions {
  int width = 320;  ///< Pixels.
  int height = 400;
  int samples = 2;  ///< Along each side of a pixel, 1..8.
  Rgb background = kWhite;
};

/// A shaded picture of a surface; without faces, of its points as small squares.
///
/// Z-buffer over samples x samples points of each pixel; normals and colours are interpolated over
/// the faces and shaded per sample with a lamp over the viewer's left shoulder and a weak one from
/// the front (Phong 1975, Blinn 1977). Back sides are shaded as front sides, darker. Of two faces
/// at the same depth the one with the lower index is seen. The same bytes everywhere: only
/// +, -, *, / and roots.
/// Packaged renderers were left aside: VTK and OSMesa need 100 to 300 MB for what is done here.
/// @param mesh    at least one vertex.
/// @param colors  one per vertex, or none.
[[nodiscard]] Image RenderMesh(const TriangleMesh& mesh,
                               std::span<const Rgb> colors,
                               const Camera& camera,
                               const RenderOptions& options);

}  // namespace cohort
