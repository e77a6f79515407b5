#include "common/geometry/io/mesh_builder.h"

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

absl::Status CheckCount(const std::string& file, int64_t count, int64_t limit, const char* what) {
  if (count <= limit) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      absl::StrCat(file, ": ", count, " ", what, "; the limit is ", limit));
}

}  // namespace

absl::Status MeshBuilder::CheckVertexCount(int64_t vertices) const {
  return CheckCount(file_, vertices, limits_.max_vertices, "vertices");
}

absl::Status MeshBuilder::CheckFaceCount(int64_t faces) const {
  return CheckCount(file_, faces, limits_.max_faces, "faces");
}

absl::Status MeshBuilder::AddVertex(const Eigen::Vector3d& vertex) {
  COHORT_RETURN_IF_ERROR(CheckVertexCount(VertexCount() + 1));
  vertices_.insert(vertices_.end(), vertex.begin(), vertex.end());
  return absl::OkStatus();
}

absl::Status MeshBuilder::AddFace(int64_t a, int64_t b, int64_t c) {
  COHORT_RETURN_IF_ERROR(CheckFaceCount(FaceCount() + 1));
  faces_.insert(faces_.end(),
                {static_cast<int32_t>(a), static_cast<int32_t>(b), static_cast<int32_t>(c)});
  return absl::OkStatus();
}

TriangleMesh MeshBuilder::Take() && {
  TriangleMesh mesh;
  mesh.vertices = Eigen::Map<const Eigen::Matrix3Xd>(vertices_.data(), 3, VertexCount());
  mesh.faces = Eigen::Map<const Matrix3Xi>(faces_.data(), 3, FaceCount());
  return mesh;
}

}  // namespace cohort
