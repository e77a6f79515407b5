#include "common/geometry/mesh/mesh_health.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include <absl/strings/str_cat.h>
#include <Eigen/Geometry>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/mesh_warnings.h"

namespace cohort {
namespace {

constexpr double kLargestCoordinate = 1e6;
// A face is flat when its height is below this share of its longest side: far under what float32
// files can express, far above the rounding of the cross product.
constexpr double kFlatShare = 1e-12;

absl::Status CheckVertices(const TriangleMesh& mesh) {
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double value = mesh.vertices(axis, v);
      if (!std::isfinite(value)) {
        return absl::InvalidArgumentError(
            absl::StrCat("vertex ", v, ": coordinate ", axis, " is not a finite number"));
      }
      if (std::abs(value) > kLargestCoordinate) {
        return absl::InvalidArgumentError(absl::StrCat("vertex ", v, ": coordinate ", axis, " is ",
                                                       value, ", beyond +-", kLargestCoordinate));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckFaces(const TriangleMesh& mesh) {
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      const int32_t vertex = mesh.faces(corner, f);
      if (vertex < 0 || vertex >= mesh.VertexCount()) {
        return absl::InvalidArgumentError(
            absl::StrCat("face ", f, " uses vertex ", vertex, " of ", mesh.VertexCount()));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRemainder(const TriangleMesh& mesh, const MeshHealth& health) {
  if (health.faces > 0 && mesh.FaceCount() == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("none of the ", health.faces, " faces has three different vertices"));
  }
  if (mesh.VertexCount() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("only ", mesh.VertexCount(), " usable vertices; a mesh needs at least 3"));
  }
  if (health.diagonal <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("all ", mesh.VertexCount(), " vertices are at the same point"));
  }
  return absl::OkStatus();
}

// Sorted rather than hashed here and below: no input can make it slow, and ties are plain.
int64_t CountDuplicateVertices(const TriangleMesh& mesh) {
  std::vector<int32_t> order(static_cast<size_t>(mesh.VertexCount()));
  std::iota(order.begin(), order.end(), 0);
  const auto position = [&mesh](int32_t v) {
    return std::tuple(mesh.vertices(0, v), mesh.vertices(1, v), mesh.vertices(2, v));
  };
  std::sort(order.begin(), order.end(),
            [&](int32_t a, int32_t b) { return position(a) < position(b); });
  int64_t duplicates = 0;
  for (size_t i = 1; i < order.size(); ++i) {
    duplicates += position(order[i - 1]) == position(order[i]) ? 1 : 0;
  }
  return duplicates;
}

bool UsesAVertexTwice(const Eigen::Vector3i& face) {
  return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

/// True for each face that has the same three vertices as an earlier one.
std::vector<bool> FindDuplicateFaces(const TriangleMesh& mesh) {
  std::vector<std::array<int32_t, 4>> keys(static_cast<size_t>(mesh.FaceCount()));
  for (size_t f = 0; f < keys.size(); ++f) {
    Eigen::Vector3i face = mesh.faces.col(static_cast<Eigen::Index>(f));
    std::sort(face.begin(), face.end());
    keys[f] = {face[0], face[1], face[2], static_cast<int32_t>(f)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> duplicate(keys.size(), false);
  for (size_t i = 1; i < keys.size(); ++i) {
    duplicate[static_cast<size_t>(keys[i][3])] =
        std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin());
  }
  return duplicate;
}

void RemoveUselessFaces(TriangleMesh& mesh, MeshHealth& health) {
  const std::vector<bool> duplicate = FindDuplicateFaces(mesh);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3i face = mesh.faces.col(f);
    if (UsesAVertexTwice(face)) {
      ++health.degenerate_faces;
    } else if (duplicate[static_cast<size_t>(f)]) {
      ++health.duplicate_faces;
    } else {
      mesh.faces.col(kept++) = face;
    }
  }
  mesh.faces.conservativeResize(Eigen::NoChange, kept);
}

void RemoveUnreferencedVertices(TriangleMesh& mesh, MeshHealth& health) {
  constexpr int32_t kUnused = -1;
  std::vector<int32_t> new_index(static_cast<size_t>(mesh.VertexCount()), kUnused);
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (const int32_t vertex : mesh.faces.col(f)) {
      new_index[static_cast<size_t>(vertex)] = 0;
    }
  }
  int32_t kept = 0;
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] != kUnused) {
      mesh.vertices.col(kept) = mesh.vertices.col(static_cast<Eigen::Index>(v)).eval();
      new_index[v] = kept++;
    }
  }
  health.unreferenced_vertices = mesh.VertexCount() - kept;
  if (health.unreferenced_vertices == 0) {
    return;
  }
  mesh.vertices.conservativeResize(Eigen::NoChange, kept);
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (int32_t& vertex : mesh.faces.col(f)) {
      vertex = new_index[static_cast<size_t>(vertex)];
    }
  }
}

void MeasureAreas(const TriangleMesh& mesh, MeshHealth& health) {
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3d ab =
        mesh.vertices.col(mesh.faces(1, f)) - mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d ac =
        mesh.vertices.col(mesh.faces(2, f)) - mesh.vertices.col(mesh.faces(0, f));
    const double longest_squared = std::max({ab.dot(ab), ac.dot(ac), (ac - ab).dot(ac - ab)});
    const double twice_area = ab.cross(ac).norm();
    if (twice_area <= kFlatShare * longest_squared) {
      ++health.degenerate_faces;
    }
    health.surface_area += 0.5 * twice_area;
  }
}

/// Each face edge as one number: lower vertex, higher vertex, and 1 if it runs downwards.
std::vector<uint64_t> SortedHalfEdges(const TriangleMesh& mesh) {
  std::vector<uint64_t> edges;
  edges.reserve(static_cast<size_t>(3 * mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      const auto from = static_cast<uint64_t>(mesh.faces(corner, f));
      const auto to = static_cast<uint64_t>(mesh.faces((corner + 1) % 3, f));
      edges.push_back(std::min(from, to) << 32U | std::max(from, to) << 1U | (from > to ? 1U : 0U));
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

void MeasureEdges(const TriangleMesh& mesh, MeshHealth& health) {
  const std::vector<uint64_t> edges = SortedHalfEdges(mesh);
  int64_t all = 0;
  int64_t boundary = 0;
  for (size_t begin = 0; begin < edges.size();) {
    size_t end = begin;
    std::array<int, 2> uses = {0, 0};
    for (; end < edges.size() && edges[end] >> 1U == edges[begin] >> 1U; ++end) {
      ++uses[edges[end] & 1U];
    }
    ++all;
    boundary += end - begin == 1 ? 1 : 0;
    health.non_manifold_edges += uses[0] > 1 || uses[1] > 1 ? 1 : 0;
    begin = end;
  }
  health.boundary_share = static_cast<double>(boundary) / static_cast<double>(all);
}

/// Root of the vertex's piece, with the path halved on the way.
size_t FindRoot(std::vector<int32_t>& parent, int32_t vertex) {
  auto v = static_cast<size_t>(vertex);
  while (parent[v] != static_cast<int32_t>(v)) {
    parent[v] = parent[static_cast<size_t>(parent[v])];
    v = static_cast<size_t>(parent[v]);
  }
  return v;
}

void MeasureComponents(const TriangleMesh& mesh, MeshHealth& health) {
  std::vector<int32_t> parent(static_cast<size_t>(mesh.VertexCount()));
  std::iota(parent.begin(), parent.end(), 0);
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 1; corner < 3; ++corner) {
      const size_t a = FindRoot(parent, mesh.faces(0, f));
      const size_t b = FindRoot(parent, mesh.faces(corner, f));
      parent[std::max(a, b)] = static_cast<int32_t>(std::min(a, b));
    }
  }
  std::vector<int64_t> faces_of(parent.size(), 0);
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    ++faces_of[FindRoot(parent, mesh.faces(0, f))];
  }
  health.components = static_cast<int64_t>(faces_of.size()) -
                      std::count(faces_of.begin(), faces_of.end(), int64_t{0});
  health.largest_component_share =
      static_cast<double>(*std::max_element(faces_of.begin(), faces_of.end())) /
      static_cast<double>(mesh.FaceCount());
}

}  // namespace

absl::Status CheckAndClean(TriangleMesh& mesh, MeshHealth& health) {
  health = MeshHealth();
  health.vertices = mesh.VertexCount();
  health.faces = mesh.FaceCount();
  health.point_cloud = mesh.IsPointCloud();
  COHORT_RETURN_IF_ERROR(CheckVertices(mesh));
  COHORT_RETURN_IF_ERROR(CheckFaces(mesh));
  health.duplicate_vertices = CountDuplicateVertices(mesh);
  if (!health.point_cloud) {
    RemoveUselessFaces(mesh, health);
    RemoveUnreferencedVertices(mesh, health);
  }
  if (mesh.VertexCount() > 0) {
    health.diagonal = BoundsOf(mesh.vertices).Diagonal();
    health.rms_radius = RmsRadius(mesh.vertices);
  }
  COHORT_RETURN_IF_ERROR(CheckRemainder(mesh, health));
  if (health.point_cloud) {
    health.components = 1;
    health.largest_component_share = 1;
  } else {
    MeasureAreas(mesh, health);
    MeasureEdges(mesh, health);
    MeasureComponents(mesh, health);
  }
  health.warnings = MeshWarnings(mesh, health);
  return absl::OkStatus();
}

}  // namespace cohort
