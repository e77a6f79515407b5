#include "server/catalog/publish_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "common/base/status_macros.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

absl::Status Rename(const std::filesystem::path& aside,
                    const std::filesystem::path& path,
                    ExistingFile existing) {
  if (existing == ExistingFile::kReplace) {
    return ::rename(aside.c_str(), path.c_str()) == 0 ? absl::OkStatus()
                                                      : ErrnoStatus(errno, "replace", path);
  }
  // A second name and no first one, because rename(2) would take the name from another file.
  if (::link(aside.c_str(), path.c_str()) != 0) {
    return errno == EEXIST
               ? absl::AlreadyExistsError(path.string() + ": is there already, not overwritten")
               : ErrnoStatus(errno, "create", path);
  }
  return ::unlink(aside.c_str()) == 0 ? absl::OkStatus() : ErrnoStatus(errno, "remove", aside);
}

}  // namespace

absl::Status PublishFile(const std::filesystem::path& aside,
                         const std::filesystem::path& path,
                         ExistingFile existing) {
  COHORT_ASSIGN_OR_RETURN(const FileDescriptor file, OpenFile(aside, O_RDONLY));
  if (::fsync(file.Get()) != 0) {
    return ErrnoStatus(errno, "sync", aside);
  }
  COHORT_RETURN_IF_ERROR(Rename(aside, path, existing));
  return SyncFolder(std::filesystem::absolute(path).parent_path());
}

}  // namespace cohort
