#include "common/geometry/io/landmarks.h"

#include <array>
#include <charconv>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/geometry/io/fcsv.h"
#include "common/geometry/io/landmark_csv.h"
#include "common/geometry/io/markups_json.h"
#include "common/geometry/io/picked_points.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

std::string_view WithoutByteOrderMark(std::string_view bytes) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (bytes.starts_with(kByteOrderMark)) {
    bytes.remove_prefix(kByteOrderMark.size());
  }
  return bytes;
}

bool EndsWith(std::string_view file_name, std::string_view extension) {
  return file_name.size() > extension.size() &&
         EqualIgnoringCase(file_name.substr(file_name.size() - extension.size()), extension);
}

/// The field, in quotes if it has a separator, a quote or outer space.
std::string CsvField(std::string_view field) {
  const bool plain = field.find_first_of(",;\t\"\r\n") == std::string_view::npos &&
                     !field.starts_with(' ') && !field.ends_with(' ');
  if (plain) {
    return std::string(field);
  }
  std::string quoted = "\"";
  for (const char c : field) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + "\"";
}

/// Shortest decimal that reads back as the same double.
std::string Decimal(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

void AppendRows(const LandmarkSet& landmarks, const std::string& prefix, std::string& csv) {
  for (Eigen::Index i = 0; i < landmarks.Count(); ++i) {
    absl::StrAppend(&csv, prefix, CsvField(landmarks.names[static_cast<size_t>(i)]));
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      absl::StrAppend(&csv, ",", Decimal(landmarks.points(axis, i)));
    }
    csv += "\r\n";
  }
}

}  // namespace

absl::Status LandmarkLimits::Validate() const {
  if (max_bytes < 1 || max_landmarks < 1 || max_name_bytes < 1) {
    return absl::InvalidArgumentError("landmark limits must be positive");
  }
  return absl::OkStatus();
}

absl::StatusOr<LandmarkFormat> DetectLandmarkFormat(std::string_view bytes,
                                                    std::string_view file_name) {
  bytes = WithoutByteOrderMark(bytes);
  const size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) {
    return FileError(file_name, "the file is empty");
  }
  if (bytes[first] == '{') {
    return LandmarkFormat::kMarkupsJson;
  }
  if (bytes[first] == '<') {
    return LandmarkFormat::kPickedPoints;
  }
  if (bytes[first] == '#' || EndsWith(file_name, ".fcsv")) {
    return LandmarkFormat::kFcsv;
  }
  const std::string_view line = bytes.substr(first, bytes.find_first_of("\r\n", first) - first);
  if (line.find_first_of(",;\t") != std::string_view::npos || EndsWith(file_name, ".csv")) {
    return LandmarkFormat::kCsv;
  }
  return FileError(file_name,
                   "neither content nor name tell a landmark file (csv, .pp, .fcsv, .mrk.json)");
}

absl::StatusOr<std::vector<MeshLandmarks>> ReadLandmarkTable(std::string_view bytes,
                                                             std::string_view file_name,
                                                             const LandmarkLimits& limits) {
  COHORT_RETURN_IF_ERROR(limits.Validate());
  if (static_cast<int64_t>(bytes.size()) > limits.max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat(std::string(file_name), ": ", bytes.size(),
                                                     " bytes; the limit is ", limits.max_bytes));
  }
  bytes = WithoutByteOrderMark(bytes);
  if (!IsValidUtf8(bytes)) {
    return FileError(file_name, "is not UTF-8 text");
  }
  COHORT_ASSIGN_OR_RETURN(const LandmarkFormat format, DetectLandmarkFormat(bytes, file_name));
  switch (format) {
    case LandmarkFormat::kCsv:
      return ReadLandmarkCsv(bytes, file_name, limits);
    case LandmarkFormat::kPickedPoints:
      return ReadPickedPoints(bytes, file_name, limits);
    case LandmarkFormat::kFcsv:
      return ReadFcsv(bytes, file_name, limits);
    case LandmarkFormat::kMarkupsJson:
      return ReadMarkupsJson(bytes, file_name, limits);
  }
  return absl::InternalError("a landmark format without a reader");
}

absl::StatusOr<LandmarkSet> ReadLandmarks(std::string_view bytes,
                                          std::string_view file_name,
                                          const LandmarkLimits& limits) {
  COHORT_ASSIGN_OR_RETURN(std::vector<MeshLandmarks> meshes,
                          ReadLandmarkTable(bytes, file_name, limits));
  if (!meshes[0].mesh.empty()) {
    return FileError(file_name, absl::StrCat("has a column of files and speaks of ", meshes.size(),
                                             " meshes; landmarks of one mesh are wanted here"));
  }
  return std::move(meshes[0].landmarks);
}

std::string WriteLandmarksCsv(const LandmarkSet& landmarks) {
  std::string csv = "name,x,y,z\r\n";
  AppendRows(landmarks, "", csv);
  return csv;
}

std::string WriteLandmarkTableCsv(std::span<const MeshLandmarks> meshes) {
  std::string csv = "file,landmark,x,y,z\r\n";
  for (const MeshLandmarks& entry : meshes) {
    AppendRows(entry.landmarks, absl::StrCat(CsvField(entry.mesh), ","), csv);
  }
  return csv;
}

}  // namespace cohort
