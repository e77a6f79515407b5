#pragma once

#include <string>
#include <utility>

#include "common/store/blob_store.h"

namespace cohort {

/// Hands out a blob that is in memory.
class WholeBlobReader final : public BlobReader {
 public:
  explicit WholeBlobReader(std::string bytes) : bytes_(std::move(bytes)) {}

  [[nodiscard]] int64_t SizeBytes() const override { return static_cast<int64_t>(bytes_.size()); }

  [[nodiscard]] absl::StatusOr<std::string> Read(int64_t max_bytes) override {
    std::string piece = bytes_.substr(position_, static_cast<size_t>(max_bytes));
    position_ += piece.size();
    return piece;
  }

 private:
  std::string bytes_;
  size_t position_ = 0;
};

}  // namespace cohort
