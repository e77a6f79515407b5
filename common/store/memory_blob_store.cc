#include "common/store/memory_blob_store.h"

#include <algorithm>
#include <utility>

namespace cohort {
namespace {

class MemoryBlobReader final : public BlobReader {
 public:
  explicit MemoryBlobReader(std::string bytes) : bytes_(std::move(bytes)) {}

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

}  // namespace

/// Borrows the store: it must outlive its writers.
class MemoryBlobWriter final : public BlobWriter {
 public:
  explicit MemoryBlobWriter(MemoryBlobStore& store) : store_(store) {}

  [[nodiscard]] absl::Status Append(std::string_view bytes) override {
    bytes_ += bytes;
    return absl::OkStatus();
  }

  [[nodiscard]] absl::StatusOr<Digest> Commit() override {
    Digest digest = Sha256::Of(bytes_);
    MutexLock lock(store_.mutex_);
    store_.blobs_.try_emplace(digest, std::move(bytes_));
    return digest;
  }

 private:
  MemoryBlobStore& store_;
  std::string bytes_;
};

absl::StatusOr<std::unique_ptr<BlobWriter>> MemoryBlobStore::StartPut() {
  return std::make_unique<MemoryBlobWriter>(*this);
}

absl::StatusOr<std::unique_ptr<BlobReader>> MemoryBlobStore::Open(const Digest& digest) {
  MutexLock lock(mutex_);
  const auto found = blobs_.find(digest);
  if (found == blobs_.end()) {
    return absl::NotFoundError("blob " + digest.Hex() + " is not in the store");
  }
  return std::make_unique<MemoryBlobReader>(found->second);
}

absl::StatusOr<bool> MemoryBlobStore::Contains(const Digest& digest) {
  MutexLock lock(mutex_);
  return blobs_.count(digest) > 0;
}

void MemoryBlobStore::Remove(const Digest& digest) {
  const MutexLock lock(mutex_);
  blobs_.erase(digest);
}

}  // namespace cohort
