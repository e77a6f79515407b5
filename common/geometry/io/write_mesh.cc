#include "common/geometry/io/write_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <cstdint>
#include <string_view>

#include <absl/strings/str_cat.h>
#include <Eigen/Geometry>

#include "common/base/byte_io.h"

namespace cohort {
namespace {

void PutPosition(const Eigen::Vector3d& position, ByteWriter& writer) {
  for (const double coordinate : position) {
    writer.Put(static_cast<float>(coordinate));
  }
}

std::string PlyHeaderText(const TriangleMesh& mesh,
                          std::span<const VertexScalar> scalars,
                          std::span<const Rgb> colors) {
  std::string header = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\ncomment written by Cohort\nelement vertex ",
      mesh.VertexCount(), "\nproperty float x\nproperty float y\nproperty float z\n");
  for (const VertexScalar& scalar : scalars) {
    absl::StrAppend(&header, "property float ", scalar.name, "\n");
  }
  if (!colors.empty()) {
    absl::StrAppend(&header, "property uchar red\nproperty uchar green\nproperty uchar blue\n");
  }
  absl::StrAppend(&header, "element face ", mesh.FaceCount(),
                  "\nproperty list uchar int vertex_indices\nend_header\n");
  return header;
}

void AppendFloat(double value, std::string& text) {
  std::array<char, 32> digits = {};
  const auto [end, error] =
      std::to_chars(digits.data(), digits.data() + digits.size(), static_cast<float>(value));
  assert(error == std::errc());
  text.append(digits.data(), end);
}

void AppendBigEndian(uint32_t value, std::string& bytes) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) {
    bytes += static_cast<char>(static_cast<uint8_t>(value >> shift));
  }
}

}  // namespace

std::string WritePly(const TriangleMesh& mesh,
                     std::span<const VertexScalar> scalars,
                     std::span<const Rgb> colors) {
  const auto vertex_count = static_cast<size_t>(mesh.VertexCount());
  assert(colors.empty() || colors.size() == vertex_count);
  assert(std::all_of(scalars.begin(), scalars.end(), [vertex_count](const VertexScalar& scalar) {
    return scalar.values.size() == vertex_count;
  }));
  ByteWriter writer;
  writer.PutBytes(PlyHeaderText(mesh, scalars, colors));
  for (size_t v = 0; v < vertex_count; ++v) {
    PutPosition(mesh.vertices.col(static_cast<Eigen::Index>(v)), writer);
    for (const VertexScalar& scalar : scalars) {
      writer.Put(scalar.values[v]);
    }
    if (!colors.empty()) {
      writer.Put(colors[v].red);
      writer.Put(colors[v].green);
      writer.Put(colors[v].blue);
    }
  }
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    writer.Put(uint8_t{3});
    for (const int32_t vertex : mesh.faces.col(f)) {
      writer.Put(vertex);
    }
  }
  return std::move(writer).Take();
}

std::string WriteObj(const TriangleMesh& mesh) {
  std::string text = "# written by Cohort\n";
  for (Eigen::Index v = 0; v < mesh.VertexCount(); ++v) {
    text += 'v';
    for (const double coordinate : mesh.vertices.col(v)) {
      text += ' ';
      AppendFloat(coordinate, text);
    }
    text += '\n';
  }
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    text += 'f';
    for (const int32_t vertex : mesh.faces.col(f)) {
      absl::StrAppend(&text, " ", int64_t{vertex} + 1);
    }
    text += '\n';
  }
  return text;
}

std::string WriteStl(const TriangleMesh& mesh) {
  constexpr size_t kTitleBytes = 80;
  std::string title = "binary STL written by Cohort";  // Must not begin with "solid".
  title.resize(kTitleBytes, ' ');
  ByteWriter writer;
  writer.PutBytes(title);
  writer.Put(static_cast<uint32_t>(mesh.FaceCount()));
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.faces(0, f));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.faces(1, f));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.faces(2, f));
    PutPosition((b - a).cross(c - a).stableNormalized(), writer);
    PutPosition(a, writer);
    PutPosition(b, writer);
    PutPosition(c, writer);
    writer.Put(uint16_t{0});
  }
  return std::move(writer).Take();
}

std::string WriteVtk(const TriangleMesh& mesh, std::span<const VertexScalar> scalars) {
  std::string vtk = absl::StrCat(
      "# vtk DataFile Version 3.0\nwritten by Cohort\nBINARY\nDATASET POLYDATA\nPOINTS ",
      mesh.VertexCount(), " float\n");
  for (int64_t v = 0; v < mesh.VertexCount(); ++v) {
    for (const double coordinate : mesh.vertices.col(v)) {
      AppendBigEndian(std::bit_cast<uint32_t>(static_cast<float>(coordinate)), vtk);
    }
  }
  const bool is_cloud = mesh.IsPointCloud();
  const int64_t cells = is_cloud ? mesh.VertexCount() : mesh.FaceCount();
  const uint32_t corners = is_cloud ? 1 : 3;
  absl::StrAppend(&vtk, is_cloud ? "\nVERTICES " : "\nPOLYGONS ", cells, " ", cells * (corners + 1),
                  "\n");
  for (int64_t cell = 0; cell < cells; ++cell) {
    AppendBigEndian(corners, vtk);
    for (uint32_t k = 0; k < corners; ++k) {
      const int64_t vertex = is_cloud ? cell : mesh.faces(k, cell);
      AppendBigEndian(static_cast<uint32_t>(vertex), vtk);
    }
  }
  absl::StrAppend(&vtk, "\n");
  if (!scalars.empty()) absl::StrAppend(&vtk, "POINT_DATA ", mesh.VertexCount(), "\n");
  for (const VertexScalar& scalar : scalars) {
    assert(std::ssize(scalar.values) == mesh.VertexCount());
    absl::StrAppend(&vtk, "SCALARS ", scalar.name, " float 1\nLOOKUP_TABLE default\n");
    for (const float value : scalar.values) AppendBigEndian(std::bit_cast<uint32_t>(value), vtk);
    absl::StrAppend(&vtk, "\n");
  }
  return vtk;
}

}  // namespace cohort
