#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

namespace cohort {

/// One zstd frame with its content size and a checksum. Each part is a block of its own, with its
/// own entropy tables: parts of unlike statistics do not spoil each other.
[[nodiscard]] std::string CompressFrame(std::span<const std::string_view> parts);

/// The content size that the frame claims.
/// @return kDataLoss if `frame` is not exactly one zstd frame that names its content size.
[[nodiscard]] absl::StatusOr<size_t> FrameContentSize(std::string_view frame);

/// The content, of a size that FrameContentSize gave and the caller found acceptable: it is
/// allocated before the first byte is unpacked.
/// @return kDataLoss if the frame is damaged.
[[nodiscard]] absl::StatusOr<std::string> DecompressFrame(std::string_view frame,
                                                          size_t content_size);

}  // namespace cohort
