#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/sha256.h"

namespace cohort {

/// The mesh files (.obj, .ply, .stl, any case) directly in `folder`, by name, bytewise.
/// @return kNotFound if there is no such folder; kFailedPrecondition if it has no mesh file.
[[nodiscard]] absl::StatusOr<std::vector<std::filesystem::path>> ListMeshFiles(
    const std::filesystem::path& folder);

struct FileDigest {
  Digest digest;
  int64_t size_bytes = 0;
};
/// @return kNotFound, kPermissionDenied or kUnknown naming the file.
[[nodiscard]] absl::StatusOr<FileDigest> HashFile(const std::filesystem::path& file);

[[nodiscard]] absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& file);

/// A file that is written a part at a time: aside, so that a reader sees the old file or the whole
/// new one. What is not finished is taken away.
class FileWriter {
 public:
  /// @return kNotFound, kPermissionDenied or kUnknown; naming the file, as do the others.
  [[nodiscard]] static absl::StatusOr<FileWriter> Create(const std::filesystem::path& file);
  FileWriter(FileWriter&& other) noexcept;
  FileWriter& operator=(FileWriter&&) = delete;
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  ~FileWriter();

  /// @return kResourceExhausted if the disk is full, else kUnknown.
  [[nodiscard]] absl::Status Append(std::string_view bytes);
  /// Syncs the file and gives it its name.
  [[nodiscard]] absl::Status Finish();

 private:
  FileWriter(std::filesystem::path file, std::filesystem::path aside, int descriptor);
  [[nodiscard]] std::string What() const;

  std::filesystem::path file_;
  std::filesystem::path aside_;
  int descriptor_ = -1;  ///< -1: there is nothing aside.
};

/// Writes aside and renames, so that a reader sees the old file or the whole new one.
/// @return kResourceExhausted if the disk is full, kPermissionDenied, else kUnknown; naming the
/// file.
[[nodiscard]] absl::Status WriteWholeFile(const std::filesystem::path& file,
                                          std::string_view bytes);

/// Creates `folder` if needed and proves that a file can be written in it.
[[nodiscard]] absl::Status PrepareFolder(const std::filesystem::path& folder);

}  // namespace cohort
