#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>

#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/triangle_mesh.h"

namespace cohort {

/// Collects what a reader finds, within the limits. Not thread-safe.
class MeshBuilder {
 public:
  MeshBuilder(std::string_view file, const ReadLimits& limits) : file_(file), limits_(limits) {}

  /// kResourceExhausted if a file that announces so many is beyond the limits.
  [[nodiscard]] absl::Status CheckVertexCount(int64_t vertices) const;
  [[nodiscard]] absl::Status CheckFaceCount(int64_t faces) const;

  /// Makes room; the caller has compared the counts with the length of the file.
  void ReserveVertices(int64_t vertices) { vertices_.reserve(3 * static_cast<size_t>(vertices)); }
  void ReserveFaces(int64_t faces) { faces_.reserve(3 * static_cast<size_t>(faces)); }

  [[nodiscard]] absl::Status AddVertex(const Eigen::Vector3d& vertex);
  [[nodiscard]] absl::Status AddFace(int64_t a, int64_t b, int64_t c);

  [[nodiscard]] int64_t VertexCount() const { return static_cast<int64_t>(vertices_.size() / 3); }
  [[nodiscard]] int64_t FaceCount() const { return static_cast<int64_t>(faces_.size() / 3); }

  [[nodiscard]] TriangleMesh Take() &&;

 private:
  std::string file_;
  ReadLimits limits_;
  std::vector<double> vertices_;
  std::vector<int32_t> faces_;
};

}  // namespace cohort
