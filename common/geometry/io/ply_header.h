#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

namespace cohort {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes of one value in a binary file.
[[nodiscard]] size_t SizeOf(PlyType type);

[[nodiscard]] bool IsInteger(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;    ///< Of the value, or of each entry of a list.
  std::optional<PlyType> length_type;  ///< Of a list's length, an integer type; none: no list.
};

struct PlyElement {
  std::string name;
  int64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Position of the property, or -1.
  [[nodiscard]] int Find(std::string_view property_name) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  size_t body_offset = 0;  ///< Where the values begin, bytes.
  int64_t body_line = 0;   ///< Its line number, for text.

  /// The element, or null. Lives as long as the header.
  [[nodiscard]] const PlyElement* Find(std::string_view element_name) const;
};

/// Parses the header, up to and including "end_header"; lines end with \n, \r\n or \r.
/// @return kInvalidArgument with file, line and reason.
[[nodiscard]] absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes,
                                                      std::string_view file_name);

}  // namespace cohort
