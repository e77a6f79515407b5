#include "common/store/posix_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "common/base/status_macros.h"

namespace cohort {

void FileDescriptor::Reset() {
  if (fd_ >= 0) {
    ::close(std::exchange(fd_, -1));
  }
}

absl::Status ErrnoStatus(int error_number,
                         std::string_view action,
                         const std::filesystem::path& path) {
  const std::string message = path.string() + ": cannot " + std::string(action) + ": " +
                              std::generic_category().message(error_number);
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return absl::ResourceExhaustedError(message);
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(message);
    default:
      return absl::UnavailableError(message);
  }
}

absl::StatusOr<FileDescriptor> OpenFile(const std::filesystem::path& path,
                                        int flags,
                                        unsigned int mode) {
  while (true) {
    const int fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
    if (fd >= 0) {
      return FileDescriptor(fd);
    }
    if (errno != EINTR) {
      return ErrnoStatus(errno, "open", path);
    }
  }
}

absl::Status WriteAll(const FileDescriptor& file,
                      std::string_view bytes,
                      const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.Get(), bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) {
      return ErrnoStatus(errno, "write", path);
    }
    bytes.remove_prefix(written < 0 ? 0 : static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::StatusOr<int64_t> ReadUpTo(const FileDescriptor& file,
                                 char* buffer,
                                 int64_t size,
                                 const std::filesystem::path& path) {
  int64_t total = 0;
  while (total < size) {
    const ssize_t count = ::read(file.Get(), buffer + total, static_cast<size_t>(size - total));
    if (count == 0) {
      break;
    }
    if (count < 0 && errno != EINTR) {
      return ErrnoStatus(errno, "read", path);
    }
    total += count < 0 ? 0 : count;
  }
  return total;
}

absl::Status SyncFolder(const std::filesystem::path& folder) {
  COHORT_ASSIGN_OR_RETURN(const FileDescriptor file, OpenFile(folder, O_RDONLY | O_DIRECTORY));
  if (::fsync(file.Get()) != 0) {
    return ErrnoStatus(errno, "sync the folder", folder);
  }
  return absl::OkStatus();
}

absl::Status EnsureFolder(const std::filesystem::path& folder) {
  if (::mkdir(folder.c_str(), 0777) == 0) {
    return absl::OkStatus();
  }
  const int error_number = errno;
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored)) {
    return absl::OkStatus();
  }
  return ErrnoStatus(error_number, "create the folder", folder);
}

}  // namespace cohort
