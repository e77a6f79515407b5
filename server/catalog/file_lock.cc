#include "server/catalog/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace cohort {

absl::StatusOr<FileLock> FileLock::Acquire(const std::filesystem::path& file) {
  const std::string name = file.string() + ".lock";
  const auto failed = [&name](const char* action) {
    return absl::UnavailableError(name + ": cannot " + action + ": " +
                                  std::generic_category().message(errno));
  };
  // Not inherited by programs that we start: a worker that outlives the server must not keep it.
  const int fd = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) {
    return failed("open");
  }
  FileLock lock(fd);
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) {
    return lock;
  }
  if (errno == EWOULDBLOCK) {
    return absl::FailedPreconditionError("another cohort-server uses " + file.string());
  }
  return failed("lock");
}

FileLock::~FileLock() {
  if (fd_ >= 0) {
    ::close(fd_);
  }
}

FileLock::FileLock(FileLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

}  // namespace cohort
