#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "tests/bench/rivals/rival.h"

namespace cohort {

/// A mesh in the form in which it is measured, for us and for the rivals.
struct BenchMesh {
  TriangleMesh mesh;  ///< Every coordinate is a float32 value: all candidates see the same points.
  Eigen::Matrix3Xf vertices;  ///< The same.
  PackedMesh packed;

  explicit BenchMesh(TriangleMesh given);
  [[nodiscard]] PointList Points() const {
    return {mesh.vertices.data(), static_cast<int64_t>(mesh.vertices.cols())};
  }
  [[nodiscard]] TriangleList Triangles() const {
    return {mesh.faces.data(), static_cast<int64_t>(mesh.faces.cols())};
  }
};

/// Faces of different people, brought into one pose. Not thread-safe.
class FaceSets {
 public:
  /// @param folder  holds faces_<n>/*.ply, n vertices each, if somebody made them; what is missing
  ///                is made with MakeDemoScan. Prepared meshes are kept in it for the next run.
  /// @param demo_spread  DemoOptions::identity_spread of those.
  explicit FaceSets(std::string folder, double demo_spread = 1)
      : folder_(std::move(folder)), demo_spread_(demo_spread) {}

  /// `count` meshes of about `vertices` vertices, no two of one person; valid until the next call.
  ///
  /// Each went through CheckAndClean and Draco, as at ingest (BASE is fastest in the vertex order
  /// that comes out), and was aligned to the first one.
  /// @return kNotFound if the folder has faces of that size, but fewer.
  [[nodiscard]] absl::StatusOr<std::span<const BenchMesh>> Get(int vertices, int count);

  /// Where the prepared meshes of that size are kept: 0000.ply, ...
  [[nodiscard]] std::string PreparedFolder(int vertices) const;
  /// How many of the folder's own faces of that size there are; 0: synthetic ones are used.
  [[nodiscard]] int MadeCount(int vertices) const;

 private:
  [[nodiscard]] std::string MadePath(int vertices, int i) const;
  [[nodiscard]] absl::StatusOr<TriangleMesh> MakeRaw(int vertices, int i) const;
  /// Aligns mesh i to `reference` and keeps it; the reference itself if that is null.
  [[nodiscard]] absl::StatusOr<TriangleMesh> Prepare(int vertices,
                                                     int i,
                                                     const TriangleMesh* reference) const;

  std::string folder_;
  double demo_spread_;
  std::map<int, std::vector<BenchMesh>> sets_;
};

/// Reads a mesh file and takes it through CheckAndClean and Draco.
[[nodiscard]] absl::StatusOr<TriangleMesh> ReadAsIngested(const std::string& path);

/// The mesh with its centroid at the origin and coordinates rounded to float32.
[[nodiscard]] TriangleMesh Centered(TriangleMesh mesh);

/// RMS of the distances from the vertices of one mesh to those of the other, mm.
[[nodiscard]] double NearestRms(const BenchMesh& source, const BenchMesh& target);

}  // namespace cohort
