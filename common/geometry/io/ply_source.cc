#include "common/geometry/io/ply_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

constexpr std::string_view kPadding("\0 \t\r\n", 5);

class TextSource : public PlySource {
 public:
  TextSource(std::string_view text, std::string_view file, int64_t first_line)
      : file_(file), lines_(text, first_line) {}

  absl::Status BeginRow() override {
    do {
      if (!lines_.Next(row_)) {
        return Error("the file ends here; rows are missing. Truncated?");
      }
    } while (IsEmpty(row_));
    return absl::OkStatus();
  }

  absl::Status EndRow() override {
    const std::string_view extra = NextWord(row_);
    return extra.empty()
               ? absl::OkStatus()
               : Error(absl::StrCat("more values than properties, from ", Quoted(extra), " on"));
  }

  absl::Status Read(PlyType type, double& value) override {
    const std::string_view word = NextWord(row_);
    if (word.empty()) {
      return Error("fewer values than properties");
    }
    if (!ParseNumber(word, value) || (IsInteger(type) && value != std::trunc(value))) {
      return Error(absl::StrCat(Quoted(word), " is not ",
                                IsInteger(type) ? "an integer" : "a finite number"));
    }
    return absl::OkStatus();
  }

  absl::Status Skip(PlyType /*type*/, int64_t count) override {
    for (int64_t i = 0; i < count; ++i) {
      if (NextWord(row_).empty()) {
        return Error("fewer values than properties");
      }
    }
    return absl::OkStatus();
  }

  [[nodiscard]] int64_t MostValues(PlyType /*type*/) const override {
    return static_cast<int64_t>(row_.size() + 1) / 2;
  }

  [[nodiscard]] int64_t MostRows(const PlyElement& element) const override {
    const auto shortest_row = static_cast<int64_t>(2 * element.properties.size());
    return static_cast<int64_t>(lines_.Remaining() + 1) / std::max<int64_t>(shortest_row, 1);
  }

  absl::Status CheckEnd() override {
    while (lines_.Next(row_)) {
      if (!IsEmpty(row_)) {
        return Error("more rows than the header announces");
      }
    }
    return absl::OkStatus();
  }

  absl::Status Error(std::string_view reason) const override {
    return LineError(file_, lines_.LineNumber(), reason);
  }

 private:
  static bool IsEmpty(std::string_view line) {
    return line.find_first_not_of(kPadding) == std::string_view::npos;
  }

  std::string_view file_;
  LineReader lines_;
  std::string_view row_;  ///< What is left of the current line.
};

class BinarySource : public PlySource {
 public:
  BinarySource(std::string_view bytes, std::string_view file, const PlyHeader& header)
      : bytes_(bytes),
        file_(file),
        offset_(header.body_offset),
        big_endian_(header.encoding == PlyEncoding::kBigEndian) {}

  absl::Status BeginRow() override { return absl::OkStatus(); }
  absl::Status EndRow() override { return absl::OkStatus(); }

  absl::Status Read(PlyType type, double& value) override {
    if (MostValues(type) < 1) {
      return Error("the file ends here; values are missing. Truncated?");
    }
    switch (type) {
      case PlyType::kInt8:
        value = Take<int8_t>();
        break;
      case PlyType::kUint8:
        value = Take<uint8_t>();
        break;
      case PlyType::kInt16:
        value = Take<int16_t>();
        break;
      case PlyType::kUint16:
        value = Take<uint16_t>();
        break;
      case PlyType::kInt32:
        value = Take<int32_t>();
        break;
      case PlyType::kUint32:
        value = Take<uint32_t>();
        break;
      case PlyType::kFloat32:
        value = static_cast<double>(Take<float>());
        break;
      case PlyType::kFloat64:
        value = Take<double>();
        break;
    }
    return absl::OkStatus();
  }

  absl::Status Skip(PlyType type, int64_t count) override {
    if (MostValues(type) < count) {
      return Error(absl::StrCat(count, " values of ", SizeOf(type), " bytes announced, ",
                                bytes_.size() - offset_, " bytes left. Truncated?"));
    }
    offset_ += static_cast<size_t>(count) * SizeOf(type);
    return absl::OkStatus();
  }

  [[nodiscard]] int64_t MostValues(PlyType type) const override {
    return static_cast<int64_t>((bytes_.size() - offset_) / SizeOf(type));
  }

  [[nodiscard]] int64_t MostRows(const PlyElement& element) const override {
    size_t shortest_row = 0;
    for (const PlyProperty& property : element.properties) {
      shortest_row += SizeOf(property.length_type.value_or(property.type));
    }
    return static_cast<int64_t>((bytes_.size() - offset_) / std::max<size_t>(shortest_row, 1));
  }

  absl::Status CheckEnd() override {
    const std::string_view trailing = bytes_.substr(offset_);
    if (trailing.find_first_not_of(kPadding) == std::string_view::npos) {
      return absl::OkStatus();
    }
    return Error(absl::StrCat(trailing.size(), " bytes after the last value: the header does not ",
                              "describe this file, or it was damaged as text"));
  }

  absl::Status Error(std::string_view reason) const override {
    return ByteError(file_, offset_, reason);
  }

 private:
  template <typename T>
  T Take() {
    char value_bytes[sizeof(T)];
    std::memcpy(value_bytes, bytes_.data() + offset_, sizeof(T));
    if (big_endian_) {
      std::reverse(std::begin(value_bytes), std::end(value_bytes));
    }
    offset_ += sizeof(T);
    T value;
    std::memcpy(&value, value_bytes, sizeof(T));
    return value;
  }

  std::string_view bytes_;
  std::string_view file_;
  size_t offset_;
  bool big_endian_;
};

}  // namespace

std::unique_ptr<PlySource> MakePlySource(const PlyHeader& header,
                                         std::string_view bytes,
                                         std::string_view file_name) {
  if (header.encoding == PlyEncoding::kAscii) {
    return std::make_unique<TextSource>(bytes.substr(header.body_offset), file_name,
                                        header.body_line);
  }
  return std::make_unique<BinarySource>(bytes, file_name, header);
}

}  // namespace cohort
