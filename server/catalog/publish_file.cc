#include "server/catalog/publish_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

absl::Status Failed(const std::filesystem::path& path, const char* action) {
  return absl::ErrnoToStatus(errno, path.string() + ": cannot " + action);
}

/// Makes a file's bytes, or a folder's names, durable.
absl::Status Sync(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    return Failed(path, "open");
  }
  absl::Status status = ::fsync(fd) == 0 ? absl::OkStatus() : Failed(path, "sync");
  ::close(fd);
  return status;
}

absl::Status Rename(const std::filesystem::path& aside,
                    const std::filesystem::path& path,
                    ExistingFile existing) {
  if (existing == ExistingFile::kReplace) {
    return ::rename(aside.c_str(), path.c_str()) == 0 ? absl::OkStatus() : Failed(path, "replace");
  }
  // A second name and no first one, because rename(2) would take the name from another file.
  if (::link(aside.c_str(), path.c_str()) != 0) {
    return errno == EEXIST
               ? absl::AlreadyExistsError(path.string() + ": is there already, not overwritten")
               : Failed(path, "create");
  }
  return ::unlink(aside.c_str()) == 0 ? absl::OkStatus() : Failed(aside, "remove");
}

}  // namespace

absl::Status PublishFile(const std::filesystem::path& aside,
                         const std::filesystem::path& path,
                         ExistingFile existing) {
  COHORT_RETURN_IF_ERROR(Sync(aside));
  COHORT_RETURN_IF_ERROR(Rename(aside, path, existing));
  return Sync(std::filesystem::absolute(path).parent_path());
}

}  // namespace cohort
