#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>

#include <absl/status/statusor.h>

namespace cohort {

/// Owns an open file descriptor. Not thread-safe.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() { Reset(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;

  [[nodiscard]] int Get() const { return fd_; }
  void Reset();

 private:
  int fd_ = -1;
};

/// "<path>: cannot <action>: <reason>" with the code that `error_number` (errno) asks for:
/// kResourceExhausted when there is no space or quota left, kPermissionDenied when access is
/// refused, else kUnavailable.
[[nodiscard]] absl::Status ErrnoStatus(int error_number,
                                       std::string_view action,
                                       const std::filesystem::path& path);

/// open(2), restarted when interrupted and closed on exec. @return as ErrnoStatus.
[[nodiscard]] absl::StatusOr<FileDescriptor> OpenFile(const std::filesystem::path& path,
                                                      int flags,
                                                      unsigned int mode = 0);

/// Writes all of `bytes`. @return as ErrnoStatus.
[[nodiscard]] absl::Status WriteAll(const FileDescriptor& file,
                                    std::string_view bytes,
                                    const std::filesystem::path& path);

/// Reads until `size` bytes or the end of the file; returns how many bytes were there.
/// @return as ErrnoStatus.
[[nodiscard]] absl::StatusOr<int64_t> ReadUpTo(const FileDescriptor& file,
                                               char* buffer,
                                               int64_t size,
                                               const std::filesystem::path& path);

/// Makes the names in a folder durable. @return as ErrnoStatus.
[[nodiscard]] absl::Status SyncFolder(const std::filesystem::path& folder);

/// Creates one folder unless it is there; its parent must be. @return as ErrnoStatus.
[[nodiscard]] absl::Status EnsureFolder(const std::filesystem::path& folder);

}  // namespace cohort
