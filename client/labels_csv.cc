#include "client/labels_csv.h"

#include <algorithm>
#include <set>
#include <vector>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"

namespace cohort {
namespace {

struct Row {
  int64_t line = 0;  ///< Where it begins, from 1.
  std::vector<std::string> fields;
};

absl::Status At(const std::string& file, int64_t line, const std::string& reason) {
  return absl::InvalidArgumentError(file + ": line " + std::to_string(line) + ": " + reason);
}

/// Splits CSV into rows; a small state machine over the characters.
class Splitter {
 public:
  Splitter(std::string_view text, const std::string& file, char separator)
      : text_(text), file_(file), separator_(separator) {}

  absl::StatusOr<std::vector<Row>> Split() {
    std::vector<Row> rows;
    while (at_ < text_.size()) {
      Row row{.line = line_, .fields = {}};
      do {
        COHORT_ASSIGN_OR_RETURN(std::string field, NextField());
        row.fields.push_back(std::move(field));
      } while (Take(separator_));
      Take('\r');
      if (at_ < text_.size() && !Take('\n')) {
        return At(file_, line_, "text after a closing quote");
      }
      ++line_;
      if (row.fields.size() > 1 || !row.fields[0].empty()) {
        rows.push_back(std::move(row));  // Empty lines are skipped.
      }
    }
    return rows;
  }

 private:
  bool Take(char c) {
    if (at_ < text_.size() && text_[at_] == c) {
      ++at_;
      return true;
    }
    return false;
  }

  absl::StatusOr<std::string> NextField() {
    std::string field;
    if (!Take('"')) {
      const size_t end = text_.find_first_of(std::string("\r\n") + separator_, at_);
      field = text_.substr(at_, end - at_);
      at_ = std::min(end, text_.size());
      return field;
    }
    const int64_t first_line = line_;
    while (at_ < text_.size()) {
      const char c = text_[at_++];
      if (c == '"' && !Take('"')) {
        return field;
      }
      line_ += c == '\n' ? 1 : 0;
      field.push_back(c);
    }
    return At(file_, first_line, "a quote is not closed");
  }

  std::string_view text_;
  const std::string& file_;
  const char separator_;
  size_t at_ = 0;
  int64_t line_ = 1;
};

absl::Status CheckHeader(const Row& header, const std::string& file) {
  const std::set<std::string> names(header.fields.begin(), header.fields.end());
  if (!names.contains("file")) {
    return At(file, header.line, "no column 'file'; the first row must name the columns");
  }
  if (names.size() != header.fields.size() || names.contains("")) {
    return At(file, header.line, "column names must be unique and not empty");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Labels> ParseLabels(std::string_view text, const std::string& file_name) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {
    text.remove_prefix(3);
  }
  if (!IsValidUtf8(text)) {
    return absl::InvalidArgumentError(file_name + ": is not UTF-8; save it as \"CSV UTF-8\"");
  }
  const std::string_view first_line = text.substr(0, text.find('\n'));
  const bool has_comma = first_line.find(',') != std::string_view::npos;
  const bool has_semicolon = first_line.find(';') != std::string_view::npos;
  const char separator = !has_comma && has_semicolon ? ';' : ',';
  COHORT_ASSIGN_OR_RETURN(const std::vector<Row> rows,
                          Splitter(text, file_name, separator).Split());
  if (rows.empty()) {
    return absl::InvalidArgumentError(file_name + ": is empty; expected columns 'file', 'person'");
  }
  const Row& header = rows[0];
  COHORT_RETURN_IF_ERROR(CheckHeader(header, file_name));
  Labels labels;
  for (size_t r = 1; r < rows.size(); ++r) {
    const Row& row = rows[r];
    if (row.fields.size() != header.fields.size()) {
      return At(file_name, row.line,
                std::to_string(row.fields.size()) + " fields, the header has " +
                    std::to_string(header.fields.size()));
    }
    std::map<std::string, std::string> values;
    std::string file;
    for (size_t c = 0; c < row.fields.size(); ++c) {
      (header.fields[c] == "file" ? file : values[header.fields[c]]) = row.fields[c];
    }
    if (!labels.emplace(file, std::move(values)).second) {
      return At(file_name, row.line, "file '" + file + "' is there twice");
    }
  }
  return labels;
}

}  // namespace cohort
