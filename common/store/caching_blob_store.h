#pragma once

#include <atomic>
#include <filesystem>
#include <memory>

#include <absl/status/statusor.h>

#include "common/store/directory_blob_store.h"
#include "common/store/folder_limit.h"

namespace cohort {

/// Another store, with what was read from it kept in a folder: for workers that reach the server's
/// store over the network. What is written goes through.
///
/// The least recently read blobs go first once the folder holds more than its limit (FolderLimit).
/// Several processes may share a folder. Every read is checked against the digest; a damaged file
/// is dropped and fetched again. A folder that cannot be written costs speed, nothing else.
/// Thread-safe.
class CachingBlobStore final : public BlobStore {
 public:
  /// @param max_bytes  > 0; larger blobs are not kept.
  /// @return as DirectoryBlobStore::Create.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CachingBlobStore>> Create(
      std::unique_ptr<BlobStore> source, const std::filesystem::path& folder, int64_t max_bytes);

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  /// Asks the source.
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;

  /// Reads that the folder answered.
  [[nodiscard]] int64_t Hits() const { return hits_; }

 private:
  CachingBlobStore(std::unique_ptr<BlobStore> source,
                   std::unique_ptr<DirectoryBlobStore> kept,
                   int64_t max_bytes);
  /// Null if the folder does not have the blob whole.
  [[nodiscard]] std::unique_ptr<BlobReader> OpenKept(const Digest& digest);
  /// Puts what `reader` gives into the folder. @return the errors of `reader`; what fails in the
  /// folder is no error.
  [[nodiscard]] absl::Status Keep(BlobReader& reader);

  const std::unique_ptr<BlobStore> source_;
  const std::unique_ptr<DirectoryBlobStore> kept_;
  FolderLimit limit_;
  std::atomic<int64_t> hits_ = 0;
};

}  // namespace cohort
