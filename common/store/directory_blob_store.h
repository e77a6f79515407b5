#pragma once

#include <filesystem>
#include <memory>

#include <absl/status/statusor.h>

#include "common/store/blob_store.h"

namespace cohort {

/// Blobs as files ROOT/sha256/ab/<64 hex>, mode 0444.
///
/// A blob is written aside (ROOT/incoming), fsynced, renamed, and its folder fsynced. Several
/// processes may use one root at once. Files left in ROOT/incoming by dead processes are removed by
/// SweepIncoming.
class DirectoryBlobStore final : public BlobStore {
 public:
  /// Creates the folders that are missing.
  /// @return kPermissionDenied / kResourceExhausted / kUnavailable naming the path and the reason.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<DirectoryBlobStore>> Create(
      const std::filesystem::path& root);

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;

  /// Removes unfinished files that were last written before `age_seconds` ago.
  [[nodiscard]] absl::Status SweepIncoming(double age_seconds);

  [[nodiscard]] const std::filesystem::path& Root() const { return root_; }

 private:
  explicit DirectoryBlobStore(std::filesystem::path root) : root_(std::move(root)) {}
  [[nodiscard]] std::filesystem::path PathOf(const Digest& digest) const;
  std::filesystem::path root_;
};

}  // namespace cohort
