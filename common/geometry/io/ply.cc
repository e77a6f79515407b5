#include "common/geometry/io/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/mesh_builder.h"
#include "common/geometry/io/ply_header.h"
#include "common/geometry/io/ply_source.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

/// An integer as read; text may hold one of any size.
std::string Digits(double integer) {
  constexpr double kExact = 0x1p53;
  return std::abs(integer) < kExact ? absl::StrCat(static_cast<int64_t>(integer))
                                    : absl::StrCat(integer);
}

class PlyBodyParser {
 public:
  PlyBodyParser(const PlyHeader& header, PlySource& source, MeshBuilder& builder)
      : header_(header), source_(source), builder_(builder) {}

  absl::Status Parse(std::string_view file) {
    COHORT_RETURN_IF_ERROR(CheckHeader(file));
    for (const PlyElement& element : header_.elements) {
      // Rows without properties take no space: there is nothing to read, however many there are.
      if (!element.properties.empty()) {
        COHORT_RETURN_IF_ERROR(ParseElement(element));
      }
    }
    return source_.CheckEnd();
  }

 private:
  absl::Status CheckHeader(std::string_view file) {
    const PlyElement* vertex = header_.Find("vertex");
    if (vertex == nullptr || vertex->count == 0) {
      return FileError(file, "the PLY header announces no vertices");
    }
    constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
    for (size_t axis = 0; axis < 3; ++axis) {
      axis_property_[axis] = vertex->Find(kAxes[axis]);
      if (axis_property_[axis] < 0 || IsList(*vertex, axis_property_[axis])) {
        return FileError(file, absl::StrCat("the PLY vertices have no number ", kAxes[axis]));
      }
    }
    vertex_count_ = vertex->count;
    COHORT_RETURN_IF_ERROR(builder_.CheckVertexCount(vertex_count_));
    const PlyElement* face = header_.Find("face");
    if (face != nullptr && face->count > 0) {
      corners_property_ = std::max(face->Find("vertex_indices"), face->Find("vertex_index"));
      if (corners_property_ < 0 || !IsList(*face, corners_property_) ||
          !IsInteger(face->properties[static_cast<size_t>(corners_property_)].type)) {
        return FileError(file, "the PLY faces have no list of integers 'vertex_indices'");
      }
      COHORT_RETURN_IF_ERROR(builder_.CheckFaceCount(face->count));
    }
    const PlyElement* strips = header_.Find("tristrips");
    if (strips != nullptr && strips->count > 0) {
      return FileError(file, "triangle strips (tristrips) cannot be read; save it with faces");
    }
    return absl::OkStatus();
  }

  static bool IsList(const PlyElement& element, int property) {
    return element.properties[static_cast<size_t>(property)].length_type.has_value();
  }

  absl::Status ParseElement(const PlyElement& element) {
    if (element.count > source_.MostRows(element)) {
      return source_.Error(absl::StrCat("the header announces ", element.count, " rows of ",
                                        Quoted(element.name), "; the rest of the file has room ",
                                        "for ", source_.MostRows(element), ". Truncated?"));
    }
    const bool is_vertex = element.name == "vertex";
    const bool is_face = element.name == "face";
    if (is_vertex) {
      builder_.ReserveVertices(element.count);
    } else if (is_face) {
      builder_.ReserveFaces(element.count);
    }
    for (row_ = 0; row_ < element.count; ++row_) {
      COHORT_RETURN_IF_ERROR(source_.BeginRow());
      COHORT_RETURN_IF_ERROR(is_vertex ? ParseVertex(element)
                             : is_face ? ParseFace(element)
                                       : SkipRow(element));
      COHORT_RETURN_IF_ERROR(source_.EndRow());
    }
    return absl::OkStatus();
  }

  absl::Status ParseVertex(const PlyElement& element) {
    Eigen::Vector3d position;
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const auto axis = std::find(axis_property_.begin(), axis_property_.end(), i);
      if (axis == axis_property_.end()) {
        COHORT_RETURN_IF_ERROR(SkipProperty(element.properties[i]));
        continue;
      }
      double& coordinate = position[axis - axis_property_.begin()];
      COHORT_RETURN_IF_ERROR(source_.Read(element.properties[i].type, coordinate));
      if (!std::isfinite(coordinate)) {
        return source_.Error(absl::StrCat("vertex ", row_, ": ", element.properties[i].name,
                                          " is not a finite number"));
      }
    }
    return builder_.AddVertex(position);
  }

  absl::Status ParseFace(const PlyElement& element) {
    for (size_t i = 0; i < element.properties.size(); ++i) {
      COHORT_RETURN_IF_ERROR(static_cast<int>(i) == corners_property_
                                 ? ParsePolygon(element.properties[i])
                                 : SkipProperty(element.properties[i]));
    }
    return absl::OkStatus();
  }

  absl::Status ParsePolygon(const PlyProperty& property) {
    int64_t corners = 0;
    COHORT_RETURN_IF_ERROR(ReadLength(property, corners));
    if (corners < 3) {
      return source_.Error(
          absl::StrCat("face ", row_, " has ", corners, " corners; it needs at least 3"));
    }
    std::array<int64_t, 3> fan = {};
    for (int64_t corner = 0; corner < corners; ++corner) {
      double vertex = 0;
      COHORT_RETURN_IF_ERROR(source_.Read(property.type, vertex));
      if (vertex < 0 || vertex >= static_cast<double>(vertex_count_)) {
        return source_.Error(absl::StrCat("face ", row_, " uses vertex ", Digits(vertex),
                                          "; the file has vertices 0 to ", vertex_count_ - 1));
      }
      fan[static_cast<size_t>(std::min<int64_t>(corner, 2))] = static_cast<int64_t>(vertex);
      if (corner >= 2) {
        COHORT_RETURN_IF_ERROR(builder_.AddFace(fan[0], fan[1], fan[2]));
        fan[1] = fan[2];
      }
    }
    return absl::OkStatus();
  }

  absl::Status SkipRow(const PlyElement& element) {
    for (const PlyProperty& property : element.properties) {
      COHORT_RETURN_IF_ERROR(SkipProperty(property));
    }
    return absl::OkStatus();
  }

  absl::Status SkipProperty(const PlyProperty& property) {
    int64_t count = 1;
    if (property.length_type.has_value()) {
      COHORT_RETURN_IF_ERROR(ReadLength(property, count));
    }
    return source_.Skip(property.type, count);
  }

  absl::Status ReadLength(const PlyProperty& list, int64_t& length) {
    double value = 0;
    COHORT_RETURN_IF_ERROR(source_.Read(*list.length_type, value));
    if (value < 0 || value > static_cast<double>(source_.MostValues(list.type))) {
      return source_.Error(absl::StrCat("list ", Quoted(list.name), " of ", Digits(value),
                                        " entries; there is room for ",
                                        source_.MostValues(list.type), ". Truncated?"));
    }
    length = static_cast<int64_t>(value);
    return absl::OkStatus();
  }

  const PlyHeader& header_;
  PlySource& source_;
  MeshBuilder& builder_;
  std::array<int, 3> axis_property_ = {-1, -1, -1};
  int corners_property_ = -1;
  int64_t vertex_count_ = 0;
  int64_t row_ = 0;
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadPly(std::string_view bytes,
                                     std::string_view file_name,
                                     const ReadLimits& limits) {
  COHORT_ASSIGN_OR_RETURN(const PlyHeader header, ReadPlyHeader(bytes, file_name));
  const std::unique_ptr<PlySource> source = MakePlySource(header, bytes, file_name);
  MeshBuilder builder(file_name, limits);
  COHORT_RETURN_IF_ERROR(PlyBodyParser(header, *source, builder).Parse(file_name));
  return std::move(builder).Take();
}

}  // namespace cohort
