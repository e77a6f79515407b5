#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/geometry/io/landmark_collector.h"
#include "common/geometry/io/landmarks.h"

namespace cohort {

/// The text without the blanks around it.
[[nodiscard]] std::string_view Trimmed(std::string_view text);

/// Makes landmarks of the rows of a table: what csv and .fcsv share. Internal to io; not
/// thread-safe. Every error names file, line and reason.
class LandmarkRows {
 public:
  LandmarkRows(std::string_view file, const LandmarkLimits& limits)
      : file_(file), collector_(file, limits) {}

  /// Splits a line into the fields of Row(), without the blanks around them; in quotes they may
  /// hold the separator, and "" is a quote.
  [[nodiscard]] absl::Status Split(std::string_view line, int64_t number, char separator);
  /// The row split last.
  [[nodiscard]] const std::vector<std::string>& Row() const { return row_; }

  /// Takes the row split last for the names of the columns: name (landmark, label), x, y, z, and
  /// perhaps file (mesh).
  [[nodiscard]] absl::Status TakeHeader();
  /// 0: no header yet.
  [[nodiscard]] size_t ColumnCount() const { return columns_ ? columns_->count : 0; }

  /// Adds the landmark of the row split last, which has a field for each column.
  /// @param to_mesh  multiplies its coordinates.
  [[nodiscard]] absl::Status AddRow(const Eigen::Vector3d& to_mesh);
  /// The same for a landmark without a position, whatever its coordinates say.
  [[nodiscard]] absl::Status AddMissingRow();

  [[nodiscard]] absl::Status Error(const std::string& reason) const;
  [[nodiscard]] absl::StatusOr<std::vector<MeshLandmarks>> Take() &&;

 private:
  static constexpr size_t kNoColumn = static_cast<size_t>(-1);
  /// Where a table has what.
  struct Columns {
    size_t name = kNoColumn;
    std::array<size_t, 3> coordinate = {kNoColumn, kNoColumn, kNoColumn};
    size_t mesh = kNoColumn;
    size_t count = 0;
  };
  [[nodiscard]] absl::Status FindColumn(std::initializer_list<std::string_view> names,
                                        size_t& column) const;
  [[nodiscard]] bool IsMissing() const;
  [[nodiscard]] absl::Status ParsePoint(Eigen::Vector3d& point) const;
  /// The file that the row names; nothing if there is no such column.
  [[nodiscard]] absl::Status TakeMesh(std::string& mesh) const;

  std::string file_;
  LandmarkCollector collector_;
  std::optional<Columns> columns_;
  std::vector<std::string> row_;
  int64_t line_number_ = 0;
};

}  // namespace cohort
