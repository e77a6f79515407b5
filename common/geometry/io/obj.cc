#include "common/geometry/io/obj.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/mesh_builder.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

enum class NormalLines { kPassOver, kRead };

class ObjParser {
 public:
  ObjParser(std::string_view text,
            std::string_view file,
            const ReadLimits& limits,
            NormalLines normal_lines)
      : file_(file), lines_(text), builder_(file, limits), normal_lines_(normal_lines) {}

  absl::StatusOr<ObjWithNormals> Parse() && {
    std::string_view line;
    while (lines_.Next(line)) {
      line_number_ = lines_.LineNumber();
      COHORT_RETURN_IF_ERROR(ParseStatement(line.substr(0, line.find('#'))));
    }
    if (builder_.VertexCount() == 0) {
      return FileError(file_, "no vertices (lines that begin with 'v'); is this an OBJ file?");
    }
    // A face may come before its vertices, so this is known only now; the worst one stands for all.
    if (highest_index_ > builder_.VertexCount()) {
      return IndexError(highest_index_line_, highest_index_);
    }
    ObjWithNormals obj;
    obj.mesh = std::move(builder_).Take();
    obj.normals = Eigen::Map<const Eigen::Matrix3Xd>(
        normals_.data(), 3, static_cast<Eigen::Index>(normals_.size() / 3));
    return obj;
  }

 private:
  absl::Status ParseStatement(std::string_view statement) {
    std::string_view rest = statement;
    const std::string_view keyword = NextWord(rest);
    if (keyword == "v") {
      return ParseVertex(Continued(rest));
    }
    if (keyword == "f") {
      return ParseFace(Continued(rest));
    }
    if (keyword == "vn" && normal_lines_ == NormalLines::kRead) {
      return ParseNormal(Continued(rest));
    }
    return absl::OkStatus();
  }

  /// The statement with the lines that follow a backslash at its end. Only for v, f, vn: names in
  /// other statements (mtllib C:\scans\) may end with one and mean no more than that.
  std::string_view Continued(std::string_view rest) {
    if (!rest.ends_with('\\')) {
      return rest;
    }
    joined_.assign(rest);
    std::string_view line;
    while (joined_.ends_with('\\')) {
      joined_.back() = ' ';
      if (!lines_.Next(line)) {
        break;
      }
      joined_.append(line.substr(0, line.find('#')));
    }
    return joined_;
  }

  absl::Status ParseVertex(std::string_view rest) {
    Eigen::Vector3d position;
    for (double& coordinate : position) {
      COHORT_RETURN_IF_ERROR(ParseCoordinate(NextWord(rest), coordinate));
    }
    double weight = 1;
    int extra = 0;
    for (std::string_view word = NextWord(rest); !word.empty(); word = NextWord(rest)) {
      if (++extra == 1) {
        COHORT_RETURN_IF_ERROR(ParseCoordinate(word, weight));
      }
    }
    if (extra == 2 || extra > 4) {
      return Error(absl::StrCat("vertex has ", 3 + extra,
                                " numbers; 3 (position), 4 (with weight), 6 or 7 (with colour) "
                                "can be read"));
    }
    if (extra == 1 && weight == 0) {
      return Error("vertex has weight 0: it is at infinity");
    }
    return builder_.AddVertex(position);
  }

  absl::Status ParseNormal(std::string_view rest) {
    Eigen::Vector3d normal;
    for (double& coordinate : normal) {
      const std::string_view word = NextWord(rest);
      if (!ParseNumber(word, coordinate)) {
        return Error(absl::StrCat("normal ", normals_.size() / 3 + 1, ": ", Quoted(word),
                                  " is not a finite number"));
      }
    }
    normals_.insert(normals_.end(), normal.begin(), normal.end());
    return absl::OkStatus();
  }

  absl::Status ParseCoordinate(std::string_view word, double& value) const {
    if (word.empty()) {
      return Error("vertex has fewer than 3 numbers");
    }
    if (!ParseNumber(word, value)) {
      return Error(absl::StrCat("vertex ", builder_.VertexCount() + 1, ": ", Quoted(word),
                                " is not a finite number"));
    }
    return absl::OkStatus();
  }

  absl::Status ParseFace(std::string_view rest) {
    int64_t first = 0;
    int64_t previous = 0;
    int64_t corners = 0;
    for (std::string_view word = NextWord(rest); !word.empty(); word = NextWord(rest)) {
      int64_t vertex = 0;
      COHORT_RETURN_IF_ERROR(ParseCorner(word, vertex));
      ++corners;
      if (corners == 1) {
        first = vertex;
      } else if (corners >= 3) {
        COHORT_RETURN_IF_ERROR(builder_.AddFace(first - 1, previous - 1, vertex - 1));
      }
      previous = vertex;
    }
    if (corners < 3) {
      return Error(absl::StrCat("face has ", corners, " corners; it needs at least 3"));
    }
    return absl::OkStatus();
  }

  /// @param vertex  index from 1, whatever way the file wrote it.
  absl::Status ParseCorner(std::string_view word, int64_t& vertex) {
    const size_t slash = word.find('/');
    if (!ParseInteger(word.substr(0, slash), vertex) || !AreTextureAndNormal(word, slash)) {
      return Error(absl::StrCat("face corner ", Quoted(word), " is not v, v/vt, v//vn or v/vt/vn"));
    }
    if (vertex > INT32_MAX || vertex < -INT32_MAX || vertex == 0 ||
        vertex + builder_.VertexCount() < 0) {
      return IndexError(line_number_, vertex);
    }
    if (vertex < 0) {
      vertex += builder_.VertexCount() + 1;
    }
    if (vertex > highest_index_) {
      highest_index_ = vertex;
      highest_index_line_ = line_number_;
    }
    return absl::OkStatus();
  }

  /// Are the parts after the first slash two integers or nothing? They are not used.
  static bool AreTextureAndNormal(std::string_view word, size_t slash) {
    for (int part = 0; part < 2 && slash != std::string_view::npos; ++part) {
      word.remove_prefix(slash + 1);
      slash = word.find('/');
      int64_t index = 0;
      const std::string_view digits = word.substr(0, slash);
      if (!digits.empty() && !ParseInteger(digits, index)) {
        return false;
      }
    }
    return slash == std::string_view::npos;
  }

  absl::Status Error(const std::string& reason) const {
    return LineError(file_, line_number_, reason);
  }

  absl::Status IndexError(int64_t line, int64_t vertex) const {
    return LineError(file_, line,
                     absl::StrCat("face uses vertex ", vertex, " of ", builder_.VertexCount()));
  }

  std::string_view file_;
  LineReader lines_;
  MeshBuilder builder_;
  NormalLines normal_lines_;
  std::vector<double> normals_;
  std::string joined_;
  int64_t line_number_ = 0;  ///< Where the statement begins.
  int64_t highest_index_ = 0;
  int64_t highest_index_line_ = 0;
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadObj(std::string_view bytes,
                                     std::string_view file_name,
                                     const ReadLimits& limits) {
  COHORT_ASSIGN_OR_RETURN(ObjWithNormals obj,
                          ObjParser(bytes, file_name, limits, NormalLines::kPassOver).Parse());
  return std::move(obj.mesh);
}

absl::StatusOr<ObjWithNormals> ReadObjWithNormals(std::string_view bytes,
                                                  std::string_view file_name,
                                                  const ReadLimits& limits) {
  return ObjParser(bytes, file_name, limits, NormalLines::kRead).Parse();
}

}  // namespace cohort
