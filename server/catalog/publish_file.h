#pragma once

#include <filesystem>

#include <absl/status/status.h>

namespace cohort {

/// What happens to a file that has the name already.
enum class ExistingFile { kReplace, kRefuse };

/// Gives a finished file its name: its bytes are on disk before the name is, and the name is on
/// disk before this returns, so that a crash leaves all of it or none.
/// @param aside  the file as it was written, in the folder of `path`.
/// @return kAlreadyExists with kRefuse; else naming the file, as absl::ErrnoToStatus
///         (kResourceExhausted when no space is left).
[[nodiscard]] absl::Status PublishFile(const std::filesystem::path& aside,
                                       const std::filesystem::path& path,
                                       ExistingFile existing);

}  // namespace cohort
