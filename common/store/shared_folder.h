#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/base/sha256.h"
#include "common/store/directory_blob_store.h"
#include "common/store/folder_limit.h"

namespace cohort {

/// What the workers of one machine share so that only one of them computes it: bytes under names,
/// in a folder. Worth it in memory (/dev/shm): writing to a disk costs what most computing does.
///
/// The least recently used go first once the folder holds more than its limit (FolderLimit). Every
/// read is checked; a damaged file is dropped. A folder that cannot be written costs speed, nothing
/// else. Thread-safe.
class SharedFolder {
 public:
  /// @param max_bytes  > 0.
  /// @return as DirectoryBlobStore::Create.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<SharedFolder>> Create(
      const std::filesystem::path& folder, int64_t max_bytes);

  /// Shows `read` the bytes under `name`, at an address that is a multiple of 64; they are gone
  /// after the call. False, without a call, if the folder does not have them whole.
  [[nodiscard]] bool Get(const Digest& name, const std::function<void(std::string_view)>& read);
  /// Keeps the pieces, one after the other, under `name`.
  void Keep(const Digest& name, std::span<const std::string_view> pieces);

 private:
  SharedFolder(std::unique_ptr<DirectoryBlobStore> files, int64_t max_bytes)
      : files_(std::move(files)), limit_(*files_, max_bytes) {}
  [[nodiscard]] absl::Status Write(const Digest& name, std::span<const std::string_view> pieces);
  void Drop(const Digest& name, const std::string& why);

  /// Keeps the names, ages and sizes only: a file's own bytes have another digest than its name.
  const std::unique_ptr<DirectoryBlobStore> files_;
  FolderLimit limit_;
};

}  // namespace cohort
