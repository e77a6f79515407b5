#pragma once

#include <map>
#include <string>

#include "common/base/mutex.h"
#include "common/store/blob_store.h"

namespace cohort {

/// Blobs in a map; for tests.
class MemoryBlobStore final : public BlobStore {
 public:
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;
  /// As if the blob had never been written.
  void Remove(const Digest& digest);

 private:
  friend class MemoryBlobWriter;
  Mutex mutex_;
  std::map<Digest, std::string> blobs_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace cohort
