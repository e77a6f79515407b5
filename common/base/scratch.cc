#include "common/base/scratch.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>

namespace cohort {
namespace {

/// An empty file that goes when it is closed, or -1.
int OpenNamelessFile() {
  std::error_code error;
  const std::string folder = std::filesystem::temp_directory_path(error).string();
  if (error) {
    return -1;
  }
  const int file = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file >= 0) {
    return file;
  }
  // File systems that know no nameless files.
  std::string name = folder + "/cohort-XXXXXX";
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) {
    unlink(name.c_str());
  }
  return named;
}

/// Null if there is no room, or no file can be mapped.
void* MapFile(size_t bytes) {
  const int file = OpenNamelessFile();
  if (file < 0) {
    return nullptr;
  }
  void* memory = MAP_FAILED;
  // All of it now: a full disk would later end the process by a signal.
  if (posix_fallocate(file, 0, static_cast<off_t>(bytes)) == 0) {
    memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  }
  close(file);
  return memory == MAP_FAILED ? nullptr : memory;
}

}  // namespace

void* AllocateScratch(size_t bytes) {
  if (bytes < kScratchFileBytes) {
    return operator new(bytes);
  }
  if (void* memory = MapFile(bytes); memory != nullptr) {
    return memory;
  }
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    throw std::bad_alloc();
  }
  return memory;
}

void FreeScratch(void* memory, size_t bytes) noexcept {
  if (bytes < kScratchFileBytes) {
    operator delete(memory);
    return;
  }
  munmap(memory, bytes);
}

}  // namespace cohort
