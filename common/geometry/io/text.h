#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/status.h>

namespace cohort {

/// Splits text into lines; a line ends with \n, \r\n or a lone \r, and the last one may end with
/// nothing. Not thread-safe.
class LineReader {
 public:
  /// @param first_line  number of the line `text` begins with.
  explicit LineReader(std::string_view text, int64_t first_line = 1)
      : text_(text), line_number_(first_line - 1) {}

  /// The next line without its end; false when there is none. The view lives as long as the text.
  [[nodiscard]] bool Next(std::string_view& line);

  /// Number of the line that Next gave last; 1 is the first.
  [[nodiscard]] int64_t LineNumber() const { return line_number_; }
  /// Bytes of the text already given out, line ends included.
  [[nodiscard]] size_t Offset() const { return offset_; }
  [[nodiscard]] size_t Remaining() const { return text_.size() - offset_; }

 private:
  std::string_view text_;
  size_t offset_ = 0;
  int64_t line_number_ = 0;
};

/// Takes the next word (between blanks) off `rest`; empty when there is none.
[[nodiscard]] std::string_view NextWord(std::string_view& rest);

/// Parses a whole word as a decimal number, the same in every locale: "1", "+.5", "-5.", "1e-3".
/// False unless all of it is one finite number; too small for a double is 0.
[[nodiscard]] bool ParseNumber(std::string_view word, double& value);

/// Parses a whole word as an integer, with or without a sign.
[[nodiscard]] bool ParseInteger(std::string_view word, int64_t& value);

/// True if both are the same but for ASCII upper and lower case.
[[nodiscard]] bool EqualIgnoringCase(std::string_view a, std::string_view b);

/// The word in quotes for a message: shortened, bytes that are not printable escaped.
[[nodiscard]] std::string Quoted(std::string_view word);

/// kInvalidArgument "<file>: line <line>: <reason>".
[[nodiscard]] absl::Status LineError(std::string_view file, int64_t line, std::string_view reason);

/// kInvalidArgument "<file>: byte <offset>: <reason>".
[[nodiscard]] absl::Status ByteError(std::string_view file, size_t offset, std::string_view reason);

/// kInvalidArgument "<file>: <reason>".
[[nodiscard]] absl::Status FileError(std::string_view file, std::string_view reason);

}  // namespace cohort
