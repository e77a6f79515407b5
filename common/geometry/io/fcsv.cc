#include "common/geometry/io/fcsv.h"

#include <optional>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/landmark_rows.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

constexpr std::string_view kFcsvColumns =
    "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// The text after `key` and "=" in a comment, or nothing.
std::optional<std::string_view> CommentValue(std::string_view line, std::string_view key) {
  std::string_view rest = Trimmed(line.substr(1));
  if (!EqualIgnoringCase(rest.substr(0, key.size()), key)) {
    return std::nullopt;
  }
  rest = Trimmed(rest.substr(key.size()));
  if (!rest.starts_with('=')) {
    return std::nullopt;
  }
  return Trimmed(rest.substr(1));
}

class FcsvReader {
 public:
  FcsvReader(std::string_view file, const LandmarkLimits& limits)
      : file_(file), rows_(file, limits) {}

  absl::Status ReadLine(std::string_view line, int64_t number) {
    if (line.starts_with('#')) {
      return ReadComment(line, number);
    }
    if (rows_.ColumnCount() == 0) {
      if (!has_version_) {
        return LineError(file_, number,
                         "no '# Markups fiducial file version' before the first row; the format "
                         "of Slicer 3 cannot be read");
      }
      COHORT_RETURN_IF_ERROR(SetColumns(kFcsvColumns, number));
    }
    if (!to_lps_) {
      return LineError(file_, number,
                       "no '# CoordinateSystem = LPS' (or RAS) before the first row");
    }
    COHORT_RETURN_IF_ERROR(rows_.Split(line, number, ','));
    const size_t columns = rows_.ColumnCount();
    if (rows_.Row().size() < columns) {
      return rows_.Error(
          absl::StrCat(rows_.Row().size(), " fields, ", columns, " columns are named"));
    }
    // vtkMRMLMarkupsNode: 0 undefined, 1 preview, 2 defined, 3 missing.
    const std::string status = rows_.Row().size() > columns ? rows_.Row()[columns] : "2";
    if (status == "0" || status == "1" || status == "3") {
      return rows_.AddMissingRow();
    }
    if (!status.empty() && status != "2") {
      return rows_.Error(absl::StrCat("position status ", Quoted(status), "; 0 to 3 are known"));
    }
    return rows_.AddRow(*to_lps_);
  }

  absl::StatusOr<std::vector<MeshLandmarks>> Take() && { return std::move(rows_).Take(); }

 private:
  absl::Status SetColumns(std::string_view names, int64_t number) {
    COHORT_RETURN_IF_ERROR(rows_.Split(names, number, ','));
    return rows_.TakeHeader();
  }

  absl::Status ReadComment(std::string_view line, int64_t number) {
    if (CommentValue(line, "Markups fiducial file version")) {
      has_version_ = true;
    } else if (const auto names = CommentValue(line, "columns")) {
      return SetColumns(*names, number);
    } else if (const auto system = CommentValue(line, "CoordinateSystem")) {
      if (EqualIgnoringCase(*system, "LPS") || *system == "1") {
        to_lps_ = Eigen::Vector3d(1, 1, 1);
      } else if (EqualIgnoringCase(*system, "RAS") || *system == "0") {
        to_lps_ = Eigen::Vector3d(-1, -1, 1);
      } else {
        return LineError(file_, number,
                         absl::StrCat("coordinate system ", Quoted(*system),
                                      "; LPS (1) and RAS (0) can be read"));
      }
    }
    return absl::OkStatus();
  }

  std::string file_;
  LandmarkRows rows_;
  bool has_version_ = false;
  std::optional<Eigen::Vector3d> to_lps_;
};

}  // namespace

absl::StatusOr<std::vector<MeshLandmarks>> ReadFcsv(std::string_view bytes,
                                                    std::string_view file_name,
                                                    const LandmarkLimits& limits) {
  FcsvReader reader(file_name, limits);
  LineReader lines(bytes);
  std::string_view line;
  while (lines.Next(line)) {
    if (!Trimmed(line).empty()) {
      COHORT_RETURN_IF_ERROR(reader.ReadLine(line, lines.LineNumber()));
    }
  }
  return std::move(reader).Take();
}

}  // namespace cohort
