#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include <absl/status/status.h>

#include "common/geometry/io/ply_header.h"

namespace cohort {

/// The values of a PLY file one after the other, whatever its encoding. Not thread-safe.
class PlySource {
 public:
  virtual ~PlySource() = default;

  /// Between these two lie the values of one row: in text, one line.
  [[nodiscard]] virtual absl::Status BeginRow() = 0;
  [[nodiscard]] virtual absl::Status EndRow() = 0;

  /// The next value; an error if the file ends or, in text, if it is no finite number of the type.
  [[nodiscard]] virtual absl::Status Read(PlyType type, double& value) = 0;
  /// Passes over `count` values without looking at them.
  [[nodiscard]] virtual absl::Status Skip(PlyType type, int64_t count) = 0;

  /// How many values of the type the rest of the row (text) or file (binary) can hold at most.
  [[nodiscard]] virtual int64_t MostValues(PlyType type) const = 0;
  /// How many rows of the element the rest of the file can hold at most.
  [[nodiscard]] virtual int64_t MostRows(const PlyElement& element) const = 0;
  /// An error if more than blanks follows.
  [[nodiscard]] virtual absl::Status CheckEnd() = 0;

  /// kInvalidArgument that names file, line or byte, and the reason.
  [[nodiscard]] virtual absl::Status Error(std::string_view reason) const = 0;
};

/// Values of `bytes` from header.body_offset on. Both views must outlive the source.
[[nodiscard]] std::unique_ptr<PlySource> MakePlySource(const PlyHeader& header,
                                                       std::string_view bytes,
                                                       std::string_view file_name);

}  // namespace cohort
