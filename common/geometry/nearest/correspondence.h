#pragma once

#include <cstdint>

namespace cohort {

/// What of the target a vertex of the source is paired with.
enum class Correspondence : uint8_t {
  kVertex,   ///< The nearest vertex: works on point clouds, depends on how dense the vertices are.
  kSurface,  ///< The nearest point of the faces: needs a surface.
};

}  // namespace cohort
