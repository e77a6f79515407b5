#include "common/geometry/io/landmark_rows.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

/// Fields of one row, without the blanks around them; in quotes they may hold the separator, and
/// "" is a quote. False if a quote is not closed or text follows it.
bool SplitRow(std::string_view row, char separator, std::vector<std::string>& fields) {
  fields.clear();
  while (true) {
    const std::string_view rest = Trimmed(row);
    const size_t next = row.find(separator);
    if (!rest.starts_with('"') || next < row.find('"')) {
      fields.emplace_back(Trimmed(row.substr(0, next)));
      if (next == std::string_view::npos) {
        return true;
      }
      row.remove_prefix(next + 1);
      continue;
    }
    row.remove_prefix(row.find('"') + 1);
    std::string& field = fields.emplace_back();
    while (true) {
      const size_t quote = row.find('"');
      if (quote == std::string_view::npos) {
        return false;
      }
      field += row.substr(0, quote);
      row.remove_prefix(quote + 1);
      if (!row.starts_with('"')) {
        break;
      }
      field += '"';
      row.remove_prefix(1);
    }
    const size_t after = row.find(separator);
    if (!Trimmed(row.substr(0, after)).empty()) {
      return false;
    }
    if (after == std::string_view::npos) {
      return true;
    }
    row.remove_prefix(after + 1);
  }
}

}  // namespace

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\v\f";
  const size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos
             ? std::string_view()
             : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

absl::Status LandmarkRows::Error(const std::string& reason) const {
  return LineError(file_, line_number_, reason);
}

absl::Status LandmarkRows::Split(std::string_view line, int64_t number, char separator) {
  line_number_ = number;
  return SplitRow(line, separator, row_)
             ? absl::OkStatus()
             : Error("a quote is not closed, or text follows a closing quote");
}

/// Finds the one column with one of these names.
absl::Status LandmarkRows::FindColumn(std::initializer_list<std::string_view> names,
                                      size_t& column) const {
  for (size_t c = 0; c < row_.size(); ++c) {
    const bool fits = std::any_of(names.begin(), names.end(), [this, c](std::string_view name) {
      return EqualIgnoringCase(row_[c], name);
    });
    if (fits && column != kNoColumn) {
      return Error(absl::StrCat("columns ", Quoted(row_[column]), " and ", Quoted(row_[c]),
                                " are the same"));
    }
    column = fits ? c : column;
  }
  return absl::OkStatus();
}

absl::Status LandmarkRows::TakeHeader() {
  Columns columns;
  columns.count = row_.size();
  COHORT_RETURN_IF_ERROR(FindColumn({"name", "landmark", "label"}, columns.name));
  COHORT_RETURN_IF_ERROR(FindColumn({"x"}, columns.coordinate[0]));
  COHORT_RETURN_IF_ERROR(FindColumn({"y"}, columns.coordinate[1]));
  COHORT_RETURN_IF_ERROR(FindColumn({"z"}, columns.coordinate[2]));
  COHORT_RETURN_IF_ERROR(FindColumn({"file", "mesh"}, columns.mesh));
  if (columns.name == kNoColumn ||
      std::count(columns.coordinate.begin(), columns.coordinate.end(), kNoColumn) > 0) {
    return Error("the columns must be named in the first row: name (or landmark, label), x, y, z");
  }
  columns_ = columns;
  return absl::OkStatus();
}

bool LandmarkRows::IsMissing() const {
  return std::all_of(columns_->coordinate.begin(), columns_->coordinate.end(),
                     [this](size_t column) {
                       return row_[column].empty() || EqualIgnoringCase(row_[column], "NA") ||
                              EqualIgnoringCase(row_[column], "NaN");
                     });
}

absl::Status LandmarkRows::ParsePoint(Eigen::Vector3d& point) const {
  constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string& field = row_[columns_->coordinate[axis]];
    if (!ParseNumber(field, point(static_cast<Eigen::Index>(axis)))) {
      return Error(
          absl::StrCat("landmark ", Quoted(row_[columns_->name]), ": ", kAxes[axis], " is ",
                       Quoted(field), ", not a finite number",
                       field.find(',') != std::string::npos ? " (decimals take a point)" : ""));
    }
  }
  return absl::OkStatus();
}

absl::Status LandmarkRows::TakeMesh(std::string& mesh) const {
  if (columns_->mesh == kNoColumn) {
    return absl::OkStatus();
  }
  mesh = row_[columns_->mesh];
  return mesh.empty() ? Error("the landmark belongs to no file") : absl::OkStatus();
}

absl::Status LandmarkRows::AddRow(const Eigen::Vector3d& to_mesh) {
  if (IsMissing()) {
    return AddMissingRow();
  }
  std::string mesh;
  COHORT_RETURN_IF_ERROR(TakeMesh(mesh));
  Eigen::Vector3d point;
  COHORT_RETURN_IF_ERROR(ParsePoint(point));
  return collector_.Add(absl::StrCat("line ", line_number_), mesh, row_[columns_->name],
                        point.cwiseProduct(to_mesh));
}

absl::Status LandmarkRows::AddMissingRow() {
  std::string mesh;
  COHORT_RETURN_IF_ERROR(TakeMesh(mesh));
  return collector_.AddMissing(absl::StrCat("line ", line_number_), mesh, row_[columns_->name]);
}

absl::StatusOr<std::vector<MeshLandmarks>> LandmarkRows::Take() && {
  return std::move(collector_).Take();
}

}  // namespace cohort
