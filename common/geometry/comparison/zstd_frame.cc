#include "common/geometry/comparison/zstd_frame.h"

#include <cassert>
#include <memory>
#include <utility>

#include <absl/strings/str_cat.h>
#include <zstd.h>

namespace cohort {
namespace {

/// Level 3 with larger values gains 1 % and costs twice the time (reference performance.md 5).
constexpr int kLevel = 3;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

void Check(size_t result) {
  assert(ZSTD_isError(result) == 0);
  static_cast<void>(result);
}

}  // namespace

std::string CompressFrame(std::span<const std::string_view> parts) {
  size_t size = 0;
  for (const std::string_view part : parts) {
    size += part.size();
  }
  const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  assert(context != nullptr);
  Check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel));
  Check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1));
  Check(ZSTD_CCtx_setPledgedSrcSize(context.get(), size));
  // A flush ends a block; its header takes 3 bytes.
  std::string frame(ZSTD_compressBound(size) + 16 * (parts.size() + 1), '\0');
  ZSTD_outBuffer output{frame.data(), frame.size(), 0};
  for (size_t i = 0; i < parts.size(); ++i) {
    ZSTD_inBuffer input{parts[i].data(), parts[i].size(), 0};
    const ZSTD_EndDirective mode = i + 1 == parts.size() ? ZSTD_e_end : ZSTD_e_flush;
    size_t left = 1;
    while (left != 0) {
      left = ZSTD_compressStream2(context.get(), &output, &input, mode);
      Check(left);
    }
  }
  frame.resize(output.pos);
  return frame;
}

absl::StatusOr<size_t> FrameContentSize(std::string_view frame) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) {
    return absl::DataLossError("not a zstd frame that names its content size");
  }
  const size_t length = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(length) != 0) {
    return absl::DataLossError(absl::StrCat("damaged zstd frame: ", ZSTD_getErrorName(length)));
  }
  if (length != frame.size()) {
    return absl::DataLossError(absl::StrCat(frame.size() - length, " bytes follow the zstd frame"));
  }
  return static_cast<size_t>(size);
}

absl::StatusOr<std::string> DecompressFrame(std::string_view frame, size_t content_size) {
  std::string content(content_size, '\0');
  const size_t size = ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size());
  if (ZSTD_isError(size) != 0) {
    return absl::DataLossError(absl::StrCat("damaged zstd frame: ", ZSTD_getErrorName(size)));
  }
  if (size != content_size) {
    return absl::DataLossError(
        absl::StrCat("the zstd frame holds ", size, " bytes, not ", content_size));
  }
  return content;
}

}  // namespace cohort
