#include "common/geometry/io/read_mesh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/obj.h"
#include "common/geometry/io/ply.h"
#include "common/geometry/io/stl.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view WithoutByteOrderMark(std::string_view bytes) {
  if (bytes.starts_with(kByteOrderMark)) {
    bytes.remove_prefix(kByteOrderMark.size());
  }
  return bytes;
}

std::string_view Extension(std::string_view file_name) {
  const size_t dot = file_name.find_last_of("./\\");
  return dot == std::string_view::npos || file_name[dot] != '.' ? "" : file_name.substr(dot + 1);
}

/// What people upload instead of a mesh; null if it is none of these.
const char* NameOfOtherFormat(std::string_view bytes) {
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kMagicWords = {{
      {"PK\x03\x04", "a zip archive; unpack it first"},
      {"\x1F\x8B", "a gzip archive; unpack it first"},
      {"DRACO", "a Draco file"},
      {"glTF", "a binary glTF file"},
      {"\x89PNG", "a PNG image"},
      {"\xFF\xD8\xFF", "a JPEG image"},
      {"%PDF", "a PDF document"},
  }};
  for (const auto& [word, name] : kMagicWords) {
    if (bytes.starts_with(word)) {
      return name;
    }
  }
  const size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && bytes[first] == '<') {
    return "an HTML or XML page (was it the mesh that was downloaded?)";
  }
  return nullptr;
}

/// True if the first line that is no comment is an OBJ statement.
bool BeginsLikeObj(std::string_view bytes) {
  constexpr std::array<std::string_view, 9> kStatements = {"v", "vn", "vt",     "f",     "o",
                                                           "g", "s",  "mtllib", "usemtl"};
  constexpr size_t kSample = 1 << 16;
  LineReader lines(bytes.substr(0, kSample));
  std::string_view line;
  while (lines.Next(line)) {
    const std::string_view word = NextWord(line);
    if (!word.empty() && !word.starts_with('#')) {
      return std::find(kStatements.begin(), kStatements.end(), word) != kStatements.end();
    }
  }
  return false;
}

bool BeginsWithWord(std::string_view bytes, std::string_view word) {
  return EqualIgnoringCase(bytes.substr(0, word.size()), word) && bytes.size() > word.size() &&
         std::string_view(" \t\r\n").find(bytes[word.size()]) != std::string_view::npos;
}

absl::Status CheckSize(std::string_view bytes,
                       std::string_view file_name,
                       const ReadLimits& limits) {
  COHORT_RETURN_IF_ERROR(limits.Validate());
  if (static_cast<int64_t>(bytes.size()) > limits.max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(std::string(file_name), ": ", bytes.size(),
                                                     " bytes; the limit is ", limits.max_bytes));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadLimits::Validate() const {
  constexpr int64_t kMostIndices = std::numeric_limits<int32_t>::max();
  if (max_bytes < 1 || max_vertices < 1 || max_faces < 1) {
    return absl::InvalidArgumentError("read limits must be positive");
  }
  if (max_vertices > kMostIndices || max_faces > kMostIndices) {
    return absl::InvalidArgumentError(
        absl::StrCat("read limits of ", max_vertices, " vertices and ", max_faces,
                     " faces; indices of 32 bits hold ", kMostIndices));
  }
  return absl::OkStatus();
}

absl::StatusOr<MeshFormat> DetectMeshFormat(std::string_view bytes, std::string_view file_name) {
  bytes = WithoutByteOrderMark(bytes);
  if (BeginsWithWord(bytes, "ply")) {
    return MeshFormat::kPly;
  }
  if (HasBinaryStlSize(bytes) || BeginsWithWord(bytes, "solid")) {
    return MeshFormat::kStl;
  }
  if (bytes.empty()) {
    return FileError(file_name, "the file is empty");
  }
  if (const char* other = NameOfOtherFormat(bytes); other != nullptr) {
    return FileError(file_name, absl::StrCat("this is ", other, ", not an OBJ, PLY or STL file"));
  }
  if (BeginsLikeObj(bytes)) {
    return MeshFormat::kObj;
  }
  constexpr std::array<std::pair<std::string_view, MeshFormat>, 3> kExtensions = {{
      {"obj", MeshFormat::kObj},
      {"ply", MeshFormat::kPly},
      {"stl", MeshFormat::kStl},
  }};
  for (const auto& [extension, format] : kExtensions) {
    if (EqualIgnoringCase(Extension(file_name), extension)) {
      return format;
    }
  }
  return FileError(file_name, "neither content nor name tell OBJ, PLY or STL");
}

absl::StatusOr<TriangleMesh> ReadMesh(std::string_view bytes,
                                      std::string_view file_name,
                                      const ReadLimits& limits) {
  COHORT_RETURN_IF_ERROR(CheckSize(bytes, file_name, limits));
  COHORT_ASSIGN_OR_RETURN(const MeshFormat format, DetectMeshFormat(bytes, file_name));
  switch (format) {
    case MeshFormat::kObj:
      return ReadObj(WithoutByteOrderMark(bytes), file_name, limits);
    case MeshFormat::kPly:
      return ReadPly(WithoutByteOrderMark(bytes), file_name, limits);
    case MeshFormat::kStl:
      return ReadStl(WithoutByteOrderMark(bytes), file_name, limits);
  }
  return absl::InternalError("a mesh format without a reader");
}

absl::StatusOr<FileMesh> ReadFileMesh(std::string_view bytes,
                                      std::string_view file_name,
                                      const ReadLimits& limits) {
  COHORT_RETURN_IF_ERROR(CheckSize(bytes, file_name, limits));
  COHORT_ASSIGN_OR_RETURN(const MeshFormat format, DetectMeshFormat(bytes, file_name));
  ObjWithNormals read;
  if (format == MeshFormat::kObj) {
    COHORT_ASSIGN_OR_RETURN(read,
                            ReadObjWithNormals(WithoutByteOrderMark(bytes), file_name, limits));
  } else {
    COHORT_ASSIGN_OR_RETURN(read.mesh, ReadMesh(bytes, file_name, limits));
  }
  FileMesh file;
  file.vertices = read.mesh.vertices.cast<float>();
  file.faces = std::move(read.mesh.faces);
  if (read.normals.cols() >= file.VertexCount()) {
    file.normals = read.normals.leftCols(file.VertexCount()).cast<float>();
  }
  return file;
}

}  // namespace cohort
