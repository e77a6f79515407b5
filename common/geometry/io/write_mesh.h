#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

struct Rgb {
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

/// One number per vertex with the name other programs will show.
struct VertexScalar {
  std::string name;           ///< A PLY property name: letters, digits, underscore.
  std::vector<float> values;  ///< n values.
};

/// Binary little-endian PLY: float x y z, then one float property per scalar, then uchar red green
/// blue if `colors` is not empty (n), faces as "uchar int vertex_indices".
/// Scalars and colours are read by CloudCompare, MeshLab and ParaView.
[[nodiscard]] std::string WritePly(const TriangleMesh& mesh,
                                   std::span<const VertexScalar> scalars = {},
                                   std::span<const Rgb> colors = {});

/// Text OBJ, coordinates with enough digits to read the same floats back.
[[nodiscard]] std::string WriteObj(const TriangleMesh& mesh);

/// Binary STL.
[[nodiscard]] std::string WriteStl(const TriangleMesh& mesh);

/// Legacy VTK 3.0, binary PolyData: points, triangles (without faces: vertices), and one SCALARS of
/// the points each. Read by ParaView, VTK and meshio.
/// Source: VTK file formats, "Simple Legacy Formats".
[[nodiscard]] std::string WriteVtk(const TriangleMesh& mesh,
                                   std::span<const VertexScalar> scalars = {});

}  // namespace cohort
