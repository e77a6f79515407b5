#include "client/memory_folder.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

#include <absl/strings/numbers.h>

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMostMegabytes = 2048;
constexpr int64_t kLeastMegabytes = 16;
constexpr int64_t kBytesPerMegabyte = 1'000'000;
constexpr std::string_view kPrefix = "cohort-run-";  ///< Then the process's number, "-", letters.

/// MemAvailable of /proc/meminfo; no limit where that is not told.
int64_t FreeMemoryMegabytes() {
  std::ifstream meminfo("/proc/meminfo");
  std::string word;
  int64_t kibibytes = 0;
  while (meminfo >> word) {
    if (word == "MemAvailable:" && meminfo >> kibibytes) {
      return kibibytes * 1024 / kBytesPerMegabyte;
    }
  }
  return std::numeric_limits<int64_t>::max();
}

int64_t RoomIn(const fs::path& root) {
  struct statvfs status {};
  if (::statvfs(root.c_str(), &status) != 0) {
    return 0;
  }
  const int64_t free_megabytes = static_cast<int64_t>(status.f_bavail) *
                                 static_cast<int64_t>(status.f_frsize) / kBytesPerMegabyte;
  return std::min({free_megabytes / 2, FreeMemoryMegabytes() / 8, kMostMegabytes});
}

/// Removes the folders of processes that are no more.
void SweepDead(const fs::path& root) {
  std::error_code error;
  for (fs::directory_iterator entry(root, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(kPrefix)) {
      continue;
    }
    const std::string number = name.substr(kPrefix.size(), name.rfind('-') - kPrefix.size());
    int process = 0;
    if (absl::SimpleAtoi(number, &process) && process > 0 && ::kill(process, 0) != 0 &&
        errno == ESRCH) {
      std::error_code ignored;  // Another user's, or another sweep's.
      fs::remove_all(entry->path(), ignored);
    }
  }
}

}  // namespace

std::unique_ptr<MemoryFolder> MemoryFolder::Create(const fs::path& root) {
  SweepDead(root);
  const int64_t megabytes = RoomIn(root);
  if (megabytes < kLeastMegabytes) {
    return nullptr;
  }
  std::string path =
      (root / (std::string(kPrefix) + std::to_string(getpid()) + "-XXXXXX")).string();
  if (::mkdtemp(path.data()) == nullptr) {
    return nullptr;
  }
  return std::unique_ptr<MemoryFolder>(new MemoryFolder(path, megabytes));
}

MemoryFolder::~MemoryFolder() {
  std::error_code ignored;  // The next process sweeps what is left.
  fs::remove_all(path_, ignored);
}

}  // namespace cohort
