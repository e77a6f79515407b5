#pragma once

#include <map>
#include <set>
#include <string>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/store/managed_blob_store.h"

namespace cohort {

/// Blobs in a map; for tests.
class MemoryBlobStore final : public ManagedBlobStore {
 public:
  MemoryBlobStore();
  /// @param clock  tells ages; must outlive the store.
  explicit MemoryBlobStore(const Clock& clock) : clock_(clock) {}

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;

  [[nodiscard]] absl::Status Visit(
      const std::function<absl::Status(const StoredBlob&)>& visit) override;
  [[nodiscard]] absl::StatusOr<StoreSpace> Space() override;
  [[nodiscard]] absl::StatusOr<bool> Renew(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> RemoveIfOlder(const Digest& digest,
                                                   double age_seconds) override;
  [[nodiscard]] absl::StatusOr<int64_t> UploadedBytes(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> ResumePut(const Digest& digest,
                                                                      int64_t offset) override;
  /// Uploads go at once, whatever their age.
  [[nodiscard]] absl::Status SweepIncoming(double age_seconds) override;

  /// What Space says from now on.
  void SetSpace(const StoreSpace& space);

 private:
  friend class MemoryBlobWriter;
  friend class MemoryUploadWriter;
  struct Blob {
    std::string bytes;
    MonotonicTime written{};
  };
  [[nodiscard]] absl::Status Quarantine(const Digest& digest) override;
  void Insert(const Digest& digest, std::string bytes);

  const Clock& clock_;
  Mutex mutex_;
  std::map<Digest, Blob> blobs_ ABSL_GUARDED_BY(mutex_);
  std::map<Digest, std::string> uploads_ ABSL_GUARDED_BY(mutex_);
  std::set<Digest> uploading_ ABSL_GUARDED_BY(mutex_);  ///< Those that a writer has.
  StoreSpace space_ ABSL_GUARDED_BY(mutex_){.free_bytes = int64_t{1} << 50,
                                            .total_bytes = int64_t{1} << 50};
};

}  // namespace cohort
