#pragma once

#include <filesystem>
#include <span>

#include <absl/status/status.h>

#include "common/store/file_blob.h"
#include "common/store/posix_file.h"

namespace cohort {

/// A whole written file that is to become a blob.
struct IncomingFile {
  const FileDescriptor& file;
  const std::filesystem::path& path;
  Digest digest;
  bool became_blob = false;  ///< Set by InstallBlobFiles; if not, the file is still there.
};

/// Makes the files the blobs of their digests, durably. Good blobs that are there are kept and made
/// young. The file system is asked to make all of them durable together.
[[nodiscard]] absl::Status InstallBlobFiles(std::span<IncomingFile> files,
                                            const std::filesystem::path& root,
                                            Durability durability);

}  // namespace cohort
