#include "common/geometry/io/landmark_csv.h"

#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/landmark_rows.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

/// A comma if the header has one, else a semicolon, else a tab.
char SeparatorOf(std::string_view header) {
  for (const char candidate : {',', ';', '\t'}) {
    if (header.find(candidate) != std::string_view::npos) {
      return candidate;
    }
  }
  return ',';
}

}  // namespace

absl::StatusOr<std::vector<MeshLandmarks>> ReadLandmarkCsv(std::string_view bytes,
                                                           std::string_view file_name,
                                                           const LandmarkLimits& limits) {
  LandmarkRows rows(file_name, limits);
  LineReader lines(bytes);
  std::string_view line;
  char separator = ',';
  while (lines.Next(line)) {
    if (Trimmed(line).empty()) {
      continue;
    }
    if (rows.ColumnCount() == 0) {
      separator = SeparatorOf(line);
      COHORT_RETURN_IF_ERROR(rows.Split(line, lines.LineNumber(), separator));
      COHORT_RETURN_IF_ERROR(rows.TakeHeader());
      continue;
    }
    COHORT_RETURN_IF_ERROR(rows.Split(line, lines.LineNumber(), separator));
    if (rows.Row().size() != rows.ColumnCount()) {
      return rows.Error(
          absl::StrCat(rows.Row().size(), " fields, the header has ", rows.ColumnCount()));
    }
    COHORT_RETURN_IF_ERROR(rows.AddRow(Eigen::Vector3d::Ones()));
  }
  return std::move(rows).Take();
}

}  // namespace cohort
