#include "common/store/memory_blob_store.h"

#include <chrono>
#include <iterator>
#include <utility>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"
#include "common/store/whole_blob_reader.h"

namespace cohort {
namespace {

const Clock& MachineClock() {
  static const SystemClock clock;
  return clock;
}

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
    store_.Insert(digest, std::move(bytes_));
    return digest;
  }

 private:
  MemoryBlobStore& store_;
  std::string bytes_;
};

/// The same for an upload.
class MemoryUploadWriter final : public BlobWriter {
 public:
  MemoryUploadWriter(MemoryBlobStore& store, Digest digest)
      : store_(store), digest_(std::move(digest)) {}
  ~MemoryUploadWriter() override {
    const MutexLock lock(store_.mutex_);
    store_.uploading_.erase(digest_);
  }
  MemoryUploadWriter(const MemoryUploadWriter&) = delete;
  MemoryUploadWriter& operator=(const MemoryUploadWriter&) = delete;

  [[nodiscard]] absl::Status Append(std::string_view bytes) override {
    const MutexLock lock(store_.mutex_);
    store_.uploads_[digest_] += bytes;
    return absl::OkStatus();
  }

  [[nodiscard]] absl::StatusOr<Digest> Commit() override {
    std::string bytes;
    {
      const MutexLock lock(store_.mutex_);
      bytes = std::exchange(store_.uploads_[digest_], {});
      store_.uploads_.erase(digest_);
    }
    if (Sha256::Of(bytes) != digest_) {
      return WithReason(absl::DataLossError("the bytes sent are not those of " + digest_.Hex()),
                        "UPLOAD_DAMAGED");
    }
    store_.Insert(digest_, std::move(bytes));
    return digest_;
  }

 private:
  MemoryBlobStore& store_;
  Digest digest_;
};

MemoryBlobStore::MemoryBlobStore() : clock_(MachineClock()) {}

void MemoryBlobStore::Insert(const Digest& digest, std::string bytes) {
  const MutexLock lock(mutex_);
  const auto [blob, is_new] = blobs_.try_emplace(digest);
  if (is_new) {
    blob->second.bytes = std::move(bytes);
  }
  blob->second.written = clock_.Now();
}

absl::StatusOr<std::unique_ptr<BlobWriter>> MemoryBlobStore::StartPut() {
  return std::make_unique<MemoryBlobWriter>(*this);
}

absl::StatusOr<std::unique_ptr<BlobReader>> MemoryBlobStore::Open(const Digest& digest) {
  MutexLock lock(mutex_);
  const auto found = blobs_.find(digest);
  if (found == blobs_.end()) {
    return WithUnreadableBlob(absl::NotFoundError("blob " + digest.Hex() + " is not in the store"),
                              digest);
  }
  return std::make_unique<WholeBlobReader>(found->second.bytes);
}

absl::StatusOr<bool> MemoryBlobStore::Contains(const Digest& digest) {
  MutexLock lock(mutex_);
  return blobs_.count(digest) > 0;
}

absl::Status MemoryBlobStore::Visit(const std::function<absl::Status(const StoredBlob&)>& visit) {
  Digest last;
  while (true) {
    StoredBlob blob;
    {
      const MutexLock lock(mutex_);
      const auto next = blobs_.upper_bound(last);
      if (next == blobs_.end()) {
        return absl::OkStatus();
      }
      blob = {.digest = next->first,
              .size_bytes = std::ssize(next->second.bytes),
              .age_seconds =
                  std::chrono::duration<double>(clock_.Now() - next->second.written).count()};
    }
    last = blob.digest;
    COHORT_RETURN_IF_ERROR(visit(blob));
  }
}

absl::StatusOr<StoreSpace> MemoryBlobStore::Space() {
  const MutexLock lock(mutex_);
  return space_;
}

void MemoryBlobStore::SetSpace(const StoreSpace& space) {
  const MutexLock lock(mutex_);
  space_ = space;
}

absl::StatusOr<bool> MemoryBlobStore::Renew(const Digest& digest) {
  const MutexLock lock(mutex_);
  const auto found = blobs_.find(digest);
  if (found == blobs_.end()) {
    return false;
  }
  found->second.written = clock_.Now();
  return true;
}

absl::StatusOr<bool> MemoryBlobStore::RemoveIfOlder(const Digest& digest, double age_seconds) {
  const MutexLock lock(mutex_);
  const auto found = blobs_.find(digest);
  if (found == blobs_.end() ||
      std::chrono::duration<double>(clock_.Now() - found->second.written).count() < age_seconds) {
    return false;
  }
  blobs_.erase(found);
  return true;
}

absl::Status MemoryBlobStore::Quarantine(const Digest& digest) {
  const MutexLock lock(mutex_);
  blobs_.erase(digest);
  return absl::OkStatus();
}

absl::StatusOr<int64_t> MemoryBlobStore::UploadedBytes(const Digest& digest) {
  const MutexLock lock(mutex_);
  const auto found = uploads_.find(digest);
  return found == uploads_.end() ? 0 : std::ssize(found->second);
}

absl::StatusOr<std::unique_ptr<BlobWriter>> MemoryBlobStore::ResumePut(const Digest& digest,
                                                                       int64_t offset) {
  const MutexLock lock(mutex_);
  const auto found = uploads_.find(digest);
  const int64_t kept = found == uploads_.end() ? 0 : std::ssize(found->second);
  if (kept != offset) {
    return WithReason(absl::OutOfRangeError("the upload goes on at byte " + std::to_string(kept)),
                      "WRONG_OFFSET");
  }
  if (!uploading_.insert(digest).second) {
    return WithReason(absl::AbortedError("the upload is going on over another connection"),
                      "UPLOAD_BUSY");
  }
  return std::make_unique<MemoryUploadWriter>(*this, digest);
}

absl::Status MemoryBlobStore::SweepIncoming(double /*age_seconds*/) {
  const MutexLock lock(mutex_);
  for (auto upload = uploads_.begin(); upload != uploads_.end();) {
    upload = uploading_.contains(upload->first) ? std::next(upload) : uploads_.erase(upload);
  }
  return absl::OkStatus();
}

}  // namespace cohort
