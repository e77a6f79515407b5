#pragma once

#include <map>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace cohort {

/// Labels of meshes by file name: column name -> value.
using Labels = std::map<std::string, std::map<std::string, std::string>>;

/// Parses RFC 4180 CSV with a header row. A column "file" is needed, "person" says whose face it
/// is, any other column is kept as it is. CRLF or LF, quotes, UTF-8 byte order mark; the separator
/// is a comma, or a semicolon if the header has no comma (as spreadsheets of some countries write).
/// @param file_name  for messages.
/// @return kInvalidArgument with file, line and reason: no column "file", a row of another length,
///         a file or column named twice, a quote left open.
[[nodiscard]] absl::StatusOr<Labels> ParseLabels(std::string_view text,
                                                 const std::string& file_name);

}  // namespace cohort
