#include "common/geometry/io/stl.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include <absl/container/flat_hash_map.h>
#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/mesh_builder.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

constexpr size_t kHeaderBytes = 84;
constexpr size_t kTriangleBytes = 50;
constexpr size_t kNormalBytes = 12;

/// Gives each position one vertex. Abseil's hash is seeded by the process, so that no file can be
/// made to collide; indices follow the file, not the hash.
class Welder {
 public:
  Welder(std::string_view file, const ReadLimits& limits) : builder_(file, limits) {}

  absl::Status AddTriangle(const std::array<Eigen::Vector3d, 3>& corners) {
    std::array<int64_t, 3> vertices = {};
    for (size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& corner = corners[i];
      const auto [place, is_new] = index_of_.try_emplace(
          {corner.x(), corner.y(), corner.z()}, static_cast<int32_t>(builder_.VertexCount()));
      if (is_new) {
        COHORT_RETURN_IF_ERROR(builder_.AddVertex(corner));
      }
      vertices[i] = place->second;
    }
    return builder_.AddFace(vertices[0], vertices[1], vertices[2]);
  }

  MeshBuilder& Builder() { return builder_; }

 private:
  MeshBuilder builder_;
  absl::flat_hash_map<std::array<double, 3>, int32_t> index_of_;
};

uint32_t AnnouncedTriangles(std::string_view bytes) {
  uint32_t triangles = 0;
  std::memcpy(&triangles, bytes.data() + kHeaderBytes - sizeof(triangles), sizeof(triangles));
  return triangles;
}

bool LooksLikeText(std::string_view bytes) {
  constexpr size_t kSample = 512;
  std::string_view rest = bytes.substr(0, kSample);
  if (rest.find('\0') != std::string_view::npos) {
    return false;
  }
  rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
  return EqualIgnoringCase(rest.substr(0, 5), "solid");
}

absl::Status CheckBinarySize(std::string_view bytes, std::string_view file) {
  if (bytes.size() < kHeaderBytes) {
    return FileError(file, absl::StrCat("no STL file: neither text that begins with 'solid' nor ",
                                        "the 84 bytes of a binary header (", bytes.size(), ")"));
  }
  const uint64_t triangles = AnnouncedTriangles(bytes);
  const uint64_t expected = kHeaderBytes + triangles * kTriangleBytes;
  if (bytes.size() < expected) {
    return ByteError(
        file, kHeaderBytes - 4,
        absl::StrCat("announces ", triangles, " triangles, which take ", expected,
                     " bytes; the file has ", bytes.size(), ". Truncated, or no STL file?"));
  }
  const std::string_view trailing = bytes.substr(static_cast<size_t>(expected));
  if (trailing.find_first_not_of(std::string_view("\0 \t\r\n", 5)) != std::string_view::npos) {
    return ByteError(file, static_cast<size_t>(expected),
                     absl::StrCat(trailing.size(), " bytes after the last of ", triangles,
                                  " triangles. Not an STL file, or damaged?"));
  }
  return absl::OkStatus();
}

absl::StatusOr<TriangleMesh> ReadBinaryStl(std::string_view bytes,
                                           std::string_view file,
                                           const ReadLimits& limits) {
  COHORT_RETURN_IF_ERROR(CheckBinarySize(bytes, file));
  const uint32_t triangles = AnnouncedTriangles(bytes);
  Welder welder(file, limits);
  COHORT_RETURN_IF_ERROR(welder.Builder().CheckFaceCount(triangles));
  welder.Builder().ReserveFaces(triangles);
  for (size_t triangle = 0; triangle < triangles; ++triangle) {
    const size_t offset = kHeaderBytes + triangle * kTriangleBytes + kNormalBytes;
    std::array<float, 9> values = {};
    std::memcpy(values.data(), bytes.data() + offset, sizeof(values));
    std::array<Eigen::Vector3d, 3> corners;
    for (size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) {
        return ByteError(file, offset + i * sizeof(float),
                         absl::StrCat("triangle ", triangle, ": coordinate is not finite"));
      }
      corners[i / 3][static_cast<Eigen::Index>(i % 3)] = static_cast<double>(values[i]);
    }
    COHORT_RETURN_IF_ERROR(welder.AddTriangle(corners));
  }
  return std::move(welder.Builder()).Take();
}

class TextStlParser {
 public:
  TextStlParser(std::string_view text, std::string_view file, const ReadLimits& limits)
      : file_(file), lines_(text), welder_(file, limits) {}

  absl::StatusOr<TriangleMesh> Parse() && {
    for (std::string_view word = Next(); !word.empty(); word = Next()) {
      if (!EqualIgnoringCase(word, "solid")) {
        return Expected("'solid'", word);
      }
      rest_ = {};  // The rest of the line is its name.
      COHORT_RETURN_IF_ERROR(ParseSolid());
    }
    return std::move(welder_.Builder()).Take();
  }

 private:
  absl::Status ParseSolid() {
    while (true) {
      const std::string_view word = Next();
      if (EqualIgnoringCase(word, "endsolid")) {
        rest_ = {};
        return absl::OkStatus();
      }
      if (!EqualIgnoringCase(word, "facet")) {
        return Expected("'facet' or 'endsolid'", word);
      }
      COHORT_RETURN_IF_ERROR(ParseFacet());
    }
  }

  absl::Status ParseFacet() {
    COHORT_RETURN_IF_ERROR(Require("normal"));
    for (int i = 0; i < 3; ++i) {
      Next();  // Not used, and programs write "nan" for the normal of a flat triangle.
    }
    COHORT_RETURN_IF_ERROR(Require("outer"));
    COHORT_RETURN_IF_ERROR(Require("loop"));
    std::array<Eigen::Vector3d, 3> corners;
    for (Eigen::Vector3d& corner : corners) {
      COHORT_RETURN_IF_ERROR(Require("vertex"));
      for (double& coordinate : corner) {
        const std::string_view word = Next();
        if (!ParseNumber(word, coordinate)) {
          return Expected("a finite number", word);
        }
      }
    }
    COHORT_RETURN_IF_ERROR(Require("endloop"));
    COHORT_RETURN_IF_ERROR(Require("endfacet"));
    return welder_.AddTriangle(corners);
  }

  /// The next word of the file, whatever line it is on; empty at the end.
  std::string_view Next() {
    while (true) {
      const std::string_view word = NextWord(rest_);
      if (!word.empty() || !lines_.Next(rest_)) {
        return word;
      }
    }
  }

  absl::Status Require(const char* keyword) {
    const std::string_view word = Next();
    return EqualIgnoringCase(word, keyword) ? absl::OkStatus()
                                            : Expected(absl::StrCat("'", keyword, "'"), word);
  }

  absl::Status Expected(const std::string& what, std::string_view found) const {
    return LineError(file_, lines_.LineNumber(),
                     absl::StrCat("expected ", what, ", found ",
                                  found.empty() ? "the end of the file" : Quoted(found)));
  }

  std::string_view file_;
  LineReader lines_;
  std::string_view rest_;  ///< Of the current line.
  Welder welder_;
};

}  // namespace

bool HasBinaryStlSize(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + uint64_t{AnnouncedTriangles(bytes)} * kTriangleBytes;
}

absl::StatusOr<TriangleMesh> ReadStl(std::string_view bytes,
                                     std::string_view file_name,
                                     const ReadLimits& limits) {
  const bool is_text = !HasBinaryStlSize(bytes) && LooksLikeText(bytes);
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, is_text
                                                 ? TextStlParser(bytes, file_name, limits).Parse()
                                                 : ReadBinaryStl(bytes, file_name, limits));
  if (mesh.FaceCount() == 0) {
    return FileError(file_name, "no triangles in this STL file");
  }
  return mesh;
}

}  // namespace cohort
