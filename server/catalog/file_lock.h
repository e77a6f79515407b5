#pragma once

#include <filesystem>
#include <string>

#include <absl/status/statusor.h>

namespace cohort {

/// The right to be the only process that uses a file, held until destroyed or the process ends.
class FileLock {
 public:
  /// Locks `file`.lock (created if missing, never removed).
  /// @return kFailedPrecondition if another holder has it, kUnavailable naming the lock file and
  ///         the reason if it cannot be opened.
  [[nodiscard]] static absl::StatusOr<FileLock> Acquire(const std::filesystem::path& file);
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  explicit FileLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace cohort
