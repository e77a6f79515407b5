#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "common/store/file_blob.h"
#include "common/store/posix_file.h"

namespace cohort {

/// Makes a whole written file the blob of its digest, durably. A good blob that is there is kept
/// and made young.
/// @return whether `incoming` has become the blob; if not, it is still there.
[[nodiscard]] absl::StatusOr<bool> InstallBlobFile(const FileDescriptor& file,
                                                   const std::filesystem::path& incoming,
                                                   const std::filesystem::path& root,
                                                   const Digest& digest,
                                                   Durability durability);

}  // namespace cohort
