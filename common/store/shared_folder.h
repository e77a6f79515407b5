#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "common/base/sha256.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/store/directory_blob_store.h"
#include "common/store/folder_limit.h"

namespace cohort {

/// Decoded meshes in a folder that the workers of one machine share: what one of them has decoded
/// the others read. Worth it in memory only: on a disk, writing it costs what decoding does.
///
/// The least recently used go first once the folder holds more than its limit (FolderLimit). Every
/// read is checked; a damaged file is dropped. A folder that cannot be written costs speed, nothing
/// else. Thread-safe.
class DecodedMeshFolder {
 public:
  /// @param max_bytes  > 0.
  /// @return as DirectoryBlobStore::Create.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<DecodedMeshFolder>> Create(
      const std::filesystem::path& folder, int64_t max_bytes);

  /// What the blob decodes to; nothing if the folder does not have it whole.
  [[nodiscard]] std::optional<TriangleMesh> Get(const Digest& blob);
  /// Keeps what `blob` decodes to. A mesh that float32 cannot hold exactly is left out: it does not
  /// come from Draco, and decoding it is cheap.
  void Keep(const Digest& blob, const TriangleMesh& mesh);

 private:
  DecodedMeshFolder(std::unique_ptr<DirectoryBlobStore> files, int64_t max_bytes)
      : files_(std::move(files)), limit_(*files_, max_bytes) {}
  [[nodiscard]] absl::Status Write(const Digest& blob, std::span<const std::string_view> pieces);
  void Drop(const Digest& blob, const std::string& why);

  /// Keeps the names, ages and sizes only: a file is named after the blob that it was decoded from,
  /// so that its own bytes have another digest.
  const std::unique_ptr<DirectoryBlobStore> files_;
  FolderLimit limit_;
};

}  // namespace cohort
