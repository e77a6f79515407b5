#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Parses a square table of numbers with names: the first row names the columns, the first field of
/// each other row names the row, both in the same order. Read are our matrix.csv, and what R writes
/// (write.csv, write.csv2, and write.table, whose first row has no corner). Separators are comma,
/// semicolon (then also decimal commas) or tab, whichever the first row has; "", NA and NaN are
/// missing values. LF or CRLF, quotes, byte order mark.
/// @param file_name  for messages.
/// @return kInvalidArgument with file, line and reason.
[[nodiscard]] absl::StatusOr<MetricMatrix> ParseMatrixCsv(std::string_view text,
                                                          const std::string& file_name);

/// Parses what numpy.save writes of a square array of float64, C order, little-endian.
/// @return kInvalidArgument with file and reason.
[[nodiscard]] absl::StatusOr<RowMajorMatrix> ParseMatrixNpy(std::string_view bytes,
                                                            const std::string& file_name);

/// Reads a matrix file by its extension: .npy, with the names in labels.txt beside it (one a line),
/// or else CSV.
/// @return kNotFound if there is no such file, or no labels.txt; as the parsers.
[[nodiscard]] absl::StatusOr<MetricMatrix> ReadMatrixFile(const std::filesystem::path& file);

}  // namespace cohort
