#include "client/matrix_files.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "client/files.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Takes fields off a line.
class LineReader {
 public:
  LineReader(std::string_view line, char separator) : rest_(line), separator_(separator) {}

  [[nodiscard]] bool AtEnd() const { return ended_; }

  /// The next field; quotes are taken away, spaces around it too.
  std::string Next() {
    while (!rest_.empty() && rest_.front() == ' ') {
      rest_.remove_prefix(1);
    }
    return !rest_.empty() && rest_.front() == '"' ? Quoted() : std::string(Plain());
  }

 private:
  std::string_view Plain() {
    const size_t end = rest_.find(separator_);
    std::string_view field = rest_.substr(0, end);
    Skip(end);
    while (!field.empty() && field.back() == ' ') {
      field.remove_suffix(1);
    }
    return field;
  }

  std::string Quoted() {
    std::string field;
    size_t at = 1;
    for (; at < rest_.size(); ++at) {
      if (rest_[at] == '"') {
        if (at + 1 >= rest_.size() || rest_[at + 1] != '"') {
          break;
        }
        ++at;
      }
      field.push_back(rest_[at]);
    }
    Skip(rest_.find(separator_, std::min(at, rest_.size())));
    return field;
  }

  void Skip(size_t separator_at) {
    ended_ = separator_at == std::string_view::npos;
    rest_.remove_prefix(ended_ ? rest_.size() : separator_at + 1);
  }

  std::string_view rest_;
  char separator_;
  bool ended_ = false;
};

std::vector<std::string> FieldsOf(std::string_view line, char separator) {
  std::vector<std::string> fields;
  LineReader reader(line, separator);
  do {
    fields.push_back(reader.Next());
  } while (!reader.AtEnd());
  return fields;
}

/// Lines without their ends; empty ones are left out.
struct Line {
  int64_t number = 0;
  std::string_view text;
};
std::vector<Line> LinesOf(std::string_view text) {
  std::vector<Line> lines;
  for (int64_t number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    if (!line.empty()) {
      lines.push_back({number, line});
    }
  }
  return lines;
}

absl::Status At(const std::string& file, int64_t line, const std::string& reason) {
  return absl::InvalidArgumentError(absl::StrCat(file, ": line ", line, ": ", reason));
}

bool ParseNumber(std::string field, char separator, double& value) {
  if (field.empty() || field == "NA" || field == "NaN" || field == "nan") {
    value = kMissing;
    return true;
  }
  if (separator == ';') {
    std::replace(field.begin(), field.end(), ',', '.');
  }
  const char* first = field.data() + (field[0] == '+' ? 1 : 0);
  const char* end = field.data() + field.size();
  const auto [parsed, error] = std::from_chars(first, end, value);
  return error == std::errc() && parsed == end;
}

char SeparatorOf(std::string_view first_line) {
  for (const char separator : {'\t', ';', ','}) {
    if (first_line.find(separator) != std::string_view::npos) {
      return separator;
    }
  }
  return ',';
}

/// One row of numbers after its name.
absl::Status ParseRow(const Line& line,
                      char separator,
                      const std::string& file,
                      Eigen::Index row,
                      MetricMatrix& matrix) {
  LineReader reader(line.text, separator);
  const std::string& expected = matrix.labels[static_cast<size_t>(row)];
  if (const std::string name = reader.Next(); name != expected) {
    return At(file, line.number,
              absl::StrCat("row ", row + 1, " is '", name, "', column ", row + 1, " is '", expected,
                           "': rows and columns must have the same names in the same "
                           "order (R: check.names = FALSE)"));
  }
  for (Eigen::Index column = 0; column < matrix.values.cols(); ++column) {
    const std::string field = reader.AtEnd() ? "" : reader.Next();
    if (!ParseNumber(field, separator, matrix.values(row, column))) {
      return At(file, line.number,
                absl::StrCat("'", field, "' under ", matrix.labels[static_cast<size_t>(column)],
                             " is no number"));
    }
  }
  return absl::OkStatus();
}

/// The value of a key of NumPy's header: what follows "'key':".
std::string_view HeaderValue(std::string_view header, std::string_view key) {
  const size_t at = header.find(absl::StrCat("'", std::string(key), "':"));
  if (at == std::string_view::npos) {
    return {};
  }
  std::string_view value = header.substr(at + key.size() + 3);
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  return value;
}

/// N of "(N, N), ...", or -1.
int64_t SquareShape(std::string_view value) {
  int64_t rows = -1;
  int64_t columns = -2;
  if (value.empty() || value.front() != '(') {
    return -1;
  }
  const char* end = value.data() + value.size();
  const char* next = std::from_chars(value.data() + 1, end, rows).ptr;
  while (next != end && (*next == ',' || *next == ' ')) {
    ++next;
  }
  next = std::from_chars(next, end, columns).ptr;
  return next != end && *next == ')' && rows == columns ? rows : -1;
}

}  // namespace

absl::StatusOr<MetricMatrix> ParseMatrixCsv(std::string_view text, const std::string& file_name) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {
    text.remove_prefix(3);
  }
  const std::vector<Line> lines = LinesOf(text);
  if (lines.size() < 2) {
    return absl::InvalidArgumentError(
        file_name + ": is no matrix: expected a row of names and a row for each of them");
  }
  const char separator = SeparatorOf(lines[0].text);
  MetricMatrix matrix;
  matrix.labels = FieldsOf(lines[0].text, separator);
  const size_t fields = FieldsOf(lines[1].text, separator).size();
  if (matrix.labels.size() == fields) {
    matrix.labels.erase(matrix.labels.begin());
  }
  const auto count = std::ssize(matrix.labels);
  if (std::ssize(lines) - 1 != count) {
    return absl::InvalidArgumentError(absl::StrCat(file_name, ": is not square: ", count,
                                                   " columns have a name, there are ",
                                                   lines.size() - 1, " rows"));
  }
  matrix.values.resize(count, count);
  for (Eigen::Index row = 0; row < count; ++row) {
    const Line& line = lines[static_cast<size_t>(row + 1)];
    COHORT_RETURN_IF_ERROR(ParseRow(line, separator, file_name, row, matrix));
    if (const auto found = std::ssize(FieldsOf(line.text, separator)); found != count + 1) {
      return At(file_name, line.number,
                absl::StrCat(found, " fields, expected a name and ", count, " numbers"));
    }
  }
  return matrix;
}

absl::StatusOr<RowMajorMatrix> ParseMatrixNpy(std::string_view bytes,
                                              const std::string& file_name) {
  static_assert(std::endian::native == std::endian::little);
  const auto refused = [&](const std::string& reason) {
    return absl::InvalidArgumentError(file_name + ": " + reason);
  };
  constexpr size_t kPrelude = 10;  // Magic, version 1.0, length of the header.
  if (bytes.size() < kPrelude || bytes.substr(0, 6) != "\x93NUMPY" || bytes[6] != 1) {
    return refused("is no NumPy file of version 1");
  }
  const size_t length = static_cast<uint8_t>(bytes[8]) + 256U * static_cast<uint8_t>(bytes[9]);
  const std::string_view header = bytes.substr(kPrelude, length);
  const int64_t count = SquareShape(HeaderValue(header, "shape"));
  if (HeaderValue(header, "descr").substr(0, 5) != "'<f8'" ||
      HeaderValue(header, "fortran_order").substr(0, 5) != "False" || count < 0) {
    return refused("is not a square array of float64 ('<f8', C order)");
  }
  const std::string_view data = bytes.substr(std::min(kPrelude + length, bytes.size()));
  constexpr int64_t kMostRows = 1'000'000;  // Its square still fits.
  if (count > kMostRows || data.size() != static_cast<uint64_t>(count * count) * sizeof(double)) {
    return refused(absl::StrCat("has ", data.size(), " bytes of numbers, ", count, " x ", count,
                                " need ", sizeof(double), " each"));
  }
  RowMajorMatrix values(count, count);
  if (count > 0) {
    std::memcpy(values.data(), data.data(), data.size());
  }
  return values;
}

absl::StatusOr<MetricMatrix> ReadMatrixFile(const std::filesystem::path& file) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, ReadWholeFile(file));
  if (file.extension() != ".npy") {
    return ParseMatrixCsv(bytes, file.string());
  }
  MetricMatrix matrix;
  COHORT_ASSIGN_OR_RETURN(matrix.values, ParseMatrixNpy(bytes, file.string()));
  const std::filesystem::path names = file.parent_path() / "labels.txt";
  const absl::StatusOr<std::string> text = ReadWholeFile(names);
  if (!text.ok()) {
    return absl::Status(text.status().code(),
                        absl::StrCat(file.string(), " needs the names of its rows: ",
                                     std::string(text.status().message())));
  }
  for (const Line& line : LinesOf(*text)) {
    matrix.labels.emplace_back(line.text);
  }
  if (std::ssize(matrix.labels) != matrix.values.rows()) {
    return absl::InvalidArgumentError(absl::StrCat(names.string(), ": ", matrix.labels.size(),
                                                   " names, ", file.string(), " has ",
                                                   matrix.values.rows(), " rows"));
  }
  return matrix;
}

}  // namespace cohort
