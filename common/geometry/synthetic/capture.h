#pragma once

#include <cstdint>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/registration/similarity.h"
#include "common/geometry/synthetic/procedural_face.h"

namespace cohort {

/// What a scanner does to a face. Lengths in mm.
struct CaptureOptions {
  int64_t vertices = 5000;
  double noise = 0.05;  ///< White noise along the normal, standard deviation.
  double warp = 0.12;   ///< Smooth error along the normal (25 to 70 mm waves), standard deviation.
};

/// Scans a face: an own triangulation and border, noise, random order of vertices and faces.
///
/// The mesh is an oriented manifold disc in the face's own frame with exactly options.vertices
/// vertices. Two seeds give two meshes of one surface that share no vertex.
[[nodiscard]] TriangleMesh CaptureFace(const ProceduralFace& face,
                                       uint64_t seed,
                                       const CaptureOptions& options);

/// Where a scan lies: x_file = scale * R(quaternion) * x_canonical + translation.
struct CapturePose {
  Similarity T_file_canonical;
  Eigen::Vector4d quaternion = {1, 0, 0, 0};  ///< Of its rotation: w, x, y, z, unit, w >= 0.
};

/// How far scans lie from the canonical pose.
struct PoseOptions {
  double max_rotation_degrees = 15;  ///< Around a random axis, 0..180.
  double max_translation = 20;       ///< Along each axis, mm, >= 0.
  double scale_sd = 0.01;            ///< Of the scale around 1, 0..0.2.
};

[[nodiscard]] CapturePose DrawPose(uint64_t seed, const PoseOptions& options);

}  // namespace cohort
