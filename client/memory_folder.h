#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <utility>

namespace cohort {

/// A folder in memory for what child processes share while they run. It is gone with this object;
/// what a killed process left is removed by the next one that makes such a folder.
class MemoryFolder {
 public:
  /// @param root  a file system in memory.
  /// @return null where there is none, or not room enough to be of use.
  [[nodiscard]] static std::unique_ptr<MemoryFolder> Create(
      const std::filesystem::path& root = "/dev/shm");
  ~MemoryFolder();
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& Path() const { return path_; }
  /// How much may be put there: half of what is free, an eighth of the machine's free memory, 2 GB.
  [[nodiscard]] int64_t Megabytes() const { return megabytes_; }

 private:
  MemoryFolder(std::filesystem::path path, int64_t megabytes)
      : path_(std::move(path)), megabytes_(megabytes) {}

  std::filesystem::path path_;
  int64_t megabytes_;
};

}  // namespace cohort
