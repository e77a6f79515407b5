#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/sha256.h"
#include "common/store/blob_store.h"

namespace cohort {

/// Whether a write waits until it survives a power cut.
enum class Durability {
  kSynced,
  kFast,  ///< For what can be fetched again.
};

// Blobs as files, for DirectoryBlobStore. ROOT/sha256/ab/<64 hex> holds a blob, ROOT/incoming what
// is being written.

[[nodiscard]] std::filesystem::path BlobsFolder(const std::filesystem::path& root);
[[nodiscard]] std::filesystem::path IncomingFolder(const std::filesystem::path& root);
/// Where the blob of `digest` (not empty) is.
[[nodiscard]] std::filesystem::path BlobPath(const std::filesystem::path& root,
                                             const Digest& digest);
/// A path in ROOT/incoming that no other process or thread uses, on any machine.
[[nodiscard]] std::filesystem::path UniqueIncomingPath(const std::filesystem::path& root);

/// Reads the file of a blob; hashes what it hands out, so that damage is found where it is read.
/// @return kNotFound, as ErrnoStatus; both marked by WithUnreadableBlob where it fits.
[[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlobFile(
    const std::filesystem::path& root, const Digest& digest);

/// Writes a file aside; it is gone after the writer unless Commit made it a blob.
[[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartBlobFile(
    const std::filesystem::path& root, Durability durability);

/// BlobStore::PutAll.
[[nodiscard]] absl::StatusOr<std::vector<Digest>> WriteBlobFiles(
    const std::filesystem::path& root,
    std::span<const std::string_view> blobs,
    Durability durability);

/// Where an upload that may be gone on with is kept.
[[nodiscard]] std::filesystem::path UploadPath(const std::filesystem::path& root,
                                               const Digest& digest);
/// As ManagedBlobStore::ResumePut.
[[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> ResumeBlobFile(
    const std::filesystem::path& root, const Digest& digest, int64_t offset);

}  // namespace cohort
