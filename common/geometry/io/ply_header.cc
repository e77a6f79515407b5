#include "common/geometry/io/ply_header.h"

#include <array>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/io/text.h"

namespace cohort {
namespace {

// Far more than any program writes; keeps the search for names from growing with a hostile header.
constexpr size_t kMostElements = 100;
constexpr size_t kMostProperties = 1000;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames = {{
    {"char", PlyType::kInt8},
    {"int8", PlyType::kInt8},
    {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},
    {"short", PlyType::kInt16},
    {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},
    {"uint16", PlyType::kUint16},
    {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},
    {"uint", PlyType::kUint32},
    {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat32},
    {"float32", PlyType::kFloat32},
    {"double", PlyType::kFloat64},
    {"float64", PlyType::kFloat64},
}};

bool ParseType(std::string_view word, PlyType& type) {
  for (const auto& [name, named_type] : kTypeNames) {
    if (word == name) {
      type = named_type;
      return true;
    }
  }
  return false;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, std::string_view file)
      : bytes_(bytes), file_(file), lines_(bytes) {}

  absl::StatusOr<PlyHeader> Parse() && {
    std::string_view line;
    if (!lines_.Next(line) || NextWord(line) != "ply") {
      return Error("a PLY file begins with the line 'ply'");
    }
    // A lone \r ends lines only if it does so from the first line on: otherwise the \n that may
    // follow "end_header\r" could be the first byte of binary values.
    lone_cr_ = bytes_[lines_.Offset() - 1] == '\r';
    while (lines_.Next(line)) {
      std::string_view rest = line;
      const std::string_view keyword = NextWord(rest);
      if (keyword == "end_header") {
        return Finish();
      }
      COHORT_RETURN_IF_ERROR(ParseStatement(keyword, rest));
    }
    return Error("the file ends before 'end_header'");
  }

 private:
  absl::Status ParseStatement(std::string_view keyword, std::string_view rest) {
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") {
      return absl::OkStatus();
    }
    if (keyword == "format") {
      return ParseFormat(rest);
    }
    if (keyword == "element") {
      return ParseElement(rest);
    }
    if (keyword == "property") {
      return ParseProperty(rest);
    }
    return Error(absl::StrCat(Quoted(keyword), " is no PLY header keyword"));
  }

  absl::Status ParseFormat(std::string_view rest) {
    const std::string_view encoding = NextWord(rest);
    const std::string_view version = NextWord(rest);
    if (encoding == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (encoding == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (encoding == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      return Error(absl::StrCat(Quoted(encoding), " is no PLY format"));
    }
    if (version != "1.0") {
      return Error(absl::StrCat("PLY version ", Quoted(version), "; 1.0 can be read"));
    }
    has_format_ = true;
    return absl::OkStatus();
  }

  absl::Status ParseElement(std::string_view rest) {
    PlyElement element;
    element.name = std::string(NextWord(rest));
    const std::string_view count = NextWord(rest);
    if (!ParseInteger(count, element.count) || element.count < 0) {
      return Error(
          absl::StrCat("element ", Quoted(element.name), ": ", Quoted(count), " is no count"));
    }
    if (header_.Find(element.name) != nullptr || header_.elements.size() == kMostElements) {
      return Error(absl::StrCat("element ", Quoted(element.name), " is there twice, or there are ",
                                "more than ", kMostElements));
    }
    header_.elements.push_back(std::move(element));
    return absl::OkStatus();
  }

  absl::Status ParseProperty(std::string_view rest) {
    if (header_.elements.empty()) {
      return Error("a property before the first element");
    }
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    std::string_view word = NextWord(rest);
    if (word == "list") {
      PlyType length_type = PlyType::kUint8;
      word = NextWord(rest);
      if (!ParseType(word, length_type) || !IsInteger(length_type)) {
        return Error(absl::StrCat(Quoted(word), " is no type for the length of a list"));
      }
      property.length_type = length_type;
      word = NextWord(rest);
    }
    if (!ParseType(word, property.type)) {
      return Error(absl::StrCat(Quoted(word), " is no PLY type"));
    }
    property.name = std::string(NextWord(rest));
    if (property.name.empty()) {
      return Error("a property without a name");
    }
    if (element.Find(property.name) >= 0 || element.properties.size() == kMostProperties) {
      return Error(absl::StrCat("property ", Quoted(property.name), " is there twice, or there ",
                                "are more than ", kMostProperties));
    }
    element.properties.push_back(std::move(property));
    return absl::OkStatus();
  }

  absl::StatusOr<PlyHeader> Finish() {
    if (!has_format_) {
      return Error("the header has no 'format'");
    }
    header_.body_offset = lines_.Offset();
    header_.body_line = lines_.LineNumber() + 1;
    const bool ends_with_crlf =
        header_.body_offset >= 2 && bytes_.substr(header_.body_offset - 2, 2) == "\r\n";
    if (lone_cr_ && ends_with_crlf) {
      --header_.body_offset;
    }
    return std::move(header_);
  }

  absl::Status Error(std::string_view reason) const {
    return LineError(file_, std::max<int64_t>(lines_.LineNumber(), 1), reason);
  }

  std::string_view bytes_;
  std::string_view file_;
  LineReader lines_;
  PlyHeader header_;
  bool has_format_ = false;
  bool lone_cr_ = false;
};

}  // namespace

size_t SizeOf(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

bool IsInteger(PlyType type) {
  return type != PlyType::kFloat32 && type != PlyType::kFloat64;
}

int PlyElement::Find(std::string_view property_name) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property_name) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

const PlyElement* PlyHeader::Find(std::string_view element_name) const {
  for (const PlyElement& element : elements) {
    if (element.name == element_name) {
      return &element;
    }
  }
  return nullptr;
}

absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes, std::string_view file_name) {
  return HeaderParser(bytes, file_name).Parse();
}

}  // namespace cohort
