#pragma once

#include <filesystem>
#include <memory>

#include <absl/status/statusor.h>

#include "common/store/file_blob.h"
#include "common/store/managed_blob_store.h"

namespace cohort {

/// Blobs as files ROOT/sha256/ab/<64 hex>, mode 0444.
///
/// A blob is written aside (ROOT/incoming), fsynced, renamed, and its folder fsynced. Several
/// processes may use one root at once. Files left in ROOT/incoming by dead processes are removed by
/// SweepIncoming. Damaged blobs are moved to ROOT/damaged/<64 hex>-<time>. A blob's age is that of
/// its file.
class DirectoryBlobStore final : public ManagedBlobStore {
 public:
  /// Creates the folders that are missing.
  /// @return kPermissionDenied / kResourceExhausted / kUnavailable naming the path and the reason.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<DirectoryBlobStore>> Create(
      const std::filesystem::path& root, Durability durability = Durability::kSynced);

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<std::vector<Digest>> PutAll(
      std::span<const std::string_view> blobs) override;

  [[nodiscard]] absl::Status Visit(
      const std::function<absl::Status(const StoredBlob&)>& visit) override;
  [[nodiscard]] absl::StatusOr<StoreSpace> Space() override;
  [[nodiscard]] absl::StatusOr<bool> Renew(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> RemoveIfOlder(const Digest& digest,
                                                   double age_seconds) override;
  [[nodiscard]] absl::StatusOr<int64_t> UploadedBytes(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> ResumePut(const Digest& digest,
                                                                      int64_t offset) override;
  [[nodiscard]] absl::Status SweepIncoming(double age_seconds) override;

  [[nodiscard]] const std::filesystem::path& Root() const { return root_; }

 private:
  DirectoryBlobStore(std::filesystem::path root, Durability durability)
      : root_(std::move(root)), durability_(durability) {}
  [[nodiscard]] absl::Status Quarantine(const Digest& digest) override;

  std::filesystem::path root_;
  Durability durability_;
};

}  // namespace cohort
