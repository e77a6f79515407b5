#include "server/catalog/checksum_vfs.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <string_view>
#include <utility>

#include "common/base/sha256.h"

namespace cohort {
namespace {

constexpr int kSmallestPage = 512;         ///< Shorter reads and writes are of the header only.
constexpr sqlite3_int64 kReservedAt = 20;  ///< Byte of the header: reserved bytes of each page.

thread_local std::string page_damage;

/// A file of SQLite's default VFS and what we know of it. SQLite gives the memory.
struct ChecksumFile {
  sqlite3_file base{};
  sqlite3_file* inner = nullptr;
  bool has_checksums = false;
  std::string name;
  std::string page;  ///< The page being written, with its checksum.
};

ChecksumFile& FileOf(sqlite3_file* file) {
  return *reinterpret_cast<ChecksumFile*>(file);
}
sqlite3_file* Inner(sqlite3_file* file) {
  return FileOf(file).inner;
}
const sqlite3_io_methods& Methods(sqlite3_file* file) {
  return *Inner(file)->pMethods;
}
sqlite3_vfs* DefaultVfs() {
  return sqlite3_vfs_find(nullptr);
}

/// Runs an operation that may need space; SQLITE_FULL if there is none. SQLite says so of a write
/// only, and calls a file that cannot be extended or synced for want of space an I/O error.
template <typename Operation>
int OrFull(const Operation& operation) {
  errno = 0;
  const int result = operation();
  const bool no_space = errno == ENOSPC || errno == EDQUOT;
  return (result & 0xff) == SQLITE_IOERR && no_space ? SQLITE_FULL : result;
}

std::string ChecksumOf(std::string_view content, int64_t number) {
  Sha256 hash;
  hash.Update(content);
  hash.Update(std::to_string(number));
  return hash.Finish().Hex().substr(0, kChecksumBytes);
}

int Close(sqlite3_file* file) {
  ChecksumFile& ours = FileOf(file);
  const int result = ours.inner->pMethods->xClose(ours.inner);
  std::free(ours.inner);
  ours.~ChecksumFile();
  return result;
}

int Read(sqlite3_file* file, void* bytes, int size, sqlite3_int64 offset) {
  ChecksumFile& ours = FileOf(file);
  const int result = ours.inner->pMethods->xRead(ours.inner, bytes, size, offset);
  if (result != SQLITE_OK || !ours.has_checksums || size < kSmallestPage) {
    return result;
  }
  const std::string_view page(static_cast<const char*>(bytes), static_cast<size_t>(size));
  const int64_t number = offset / size + 1;
  const size_t content = page.size() - kChecksumBytes;
  if (page.substr(content) != ChecksumOf(page.substr(0, content), number)) {
    page_damage =
        "page " + std::to_string(number) + " of " + ours.name + " does not have its checksum";
    return SQLITE_CORRUPT;
  }
  return SQLITE_OK;
}

int Write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
  ChecksumFile& ours = FileOf(file);
  if (ours.has_checksums && size >= kSmallestPage) {
    ours.page.assign(static_cast<const char*>(bytes), static_cast<size_t>(size) - kChecksumBytes);
    ours.page += ChecksumOf(ours.page, offset / size + 1);
    bytes = ours.page.data();
  }
  return OrFull([&] { return ours.inner->pMethods->xWrite(ours.inner, bytes, size, offset); });
}

int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  return OrFull([&] { return Methods(file).xTruncate(Inner(file), size); });
}
int Sync(sqlite3_file* file, int flags) {
  return OrFull([&] { return Methods(file).xSync(Inner(file), flags); });
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Methods(file).xFileSize(Inner(file), size);
}
int Lock(sqlite3_file* file, int level) {
  return Methods(file).xLock(Inner(file), level);
}
int Unlock(sqlite3_file* file, int level) {
  return Methods(file).xUnlock(Inner(file), level);
}
int CheckReservedLock(sqlite3_file* file, int* locked) {
  return Methods(file).xCheckReservedLock(Inner(file), locked);
}
int FileControl(sqlite3_file* file, int operation, void* argument) {
  return Methods(file).xFileControl(Inner(file), operation, argument);
}
int SectorSize(sqlite3_file* file) {
  return Methods(file).xSectorSize(Inner(file));
}
int DeviceCharacteristics(sqlite3_file* file) {
  return Methods(file).xDeviceCharacteristics(Inner(file));
}
int ShmMap(sqlite3_file* file, int region, int size, int extend, void volatile** memory) {
  return OrFull([&] { return Methods(file).xShmMap(Inner(file), region, size, extend, memory); });
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Methods(file).xShmLock(Inner(file), offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) {
  Methods(file).xShmBarrier(Inner(file));
}
int ShmUnmap(sqlite3_file* file, int wants_delete) {
  return Methods(file).xShmUnmap(Inner(file), wants_delete);
}

// Version 2: with the shared memory of a write-ahead log, without memory-mapped pages, which would
// come past Read.
constexpr sqlite3_io_methods kMethods = {2,
                                         Close,
                                         Read,
                                         Write,
                                         Truncate,
                                         Sync,
                                         FileSize,
                                         Lock,
                                         Unlock,
                                         CheckReservedLock,
                                         FileControl,
                                         SectorSize,
                                         DeviceCharacteristics,
                                         ShmMap,
                                         ShmLock,
                                         ShmBarrier,
                                         ShmUnmap,
                                         nullptr,
                                         nullptr};

/// A new file is to have checksums; another one says so in its header.
int LookForChecksums(ChecksumFile& ours) {
  sqlite3_int64 size = 0;
  if (const int result = ours.inner->pMethods->xFileSize(ours.inner, &size); result != SQLITE_OK) {
    return result;
  }
  unsigned char reserved = kChecksumBytes;
  if (size > kReservedAt) {
    const int result = ours.inner->pMethods->xRead(ours.inner, &reserved, 1, kReservedAt);
    if (result != SQLITE_OK) {
      return result;
    }
  }
  ours.has_checksums = reserved == kChecksumBytes;
  return SQLITE_OK;
}

int Open(sqlite3_vfs* /*vfs*/, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  sqlite3_vfs* inner_vfs = DefaultVfs();
  file->pMethods = nullptr;
  auto* inner =
      static_cast<sqlite3_file*>(std::calloc(1, static_cast<size_t>(inner_vfs->szOsFile)));
  if (inner == nullptr) {
    return SQLITE_NOMEM;
  }
  int result = inner_vfs->xOpen(inner_vfs, name, inner, flags, out_flags);
  auto* ours = new (file) ChecksumFile();
  ours->inner = inner;
  ours->name = name == nullptr ? "a temporary file" : name;
  if (result == SQLITE_OK && (flags & SQLITE_OPEN_MAIN_DB) != 0) {
    result = LookForChecksums(*ours);
  }
  if (result == SQLITE_OK) {
    ours->base.pMethods = &kMethods;
    return SQLITE_OK;
  }
  if (inner->pMethods != nullptr) {
    inner->pMethods->xClose(inner);
  }
  std::free(inner);
  ours->~ChecksumFile();
  file->pMethods = nullptr;
  return result;
}

int Delete(sqlite3_vfs* /*vfs*/, const char* name, int sync_folder) {
  return DefaultVfs()->xDelete(DefaultVfs(), name, sync_folder);
}
int Access(sqlite3_vfs* /*vfs*/, const char* name, int flags, int* result) {
  return DefaultVfs()->xAccess(DefaultVfs(), name, flags, result);
}
int FullPathname(sqlite3_vfs* /*vfs*/, const char* name, int size, char* path) {
  return DefaultVfs()->xFullPathname(DefaultVfs(), name, size, path);
}
int Randomness(sqlite3_vfs* /*vfs*/, int size, char* bytes) {
  return DefaultVfs()->xRandomness(DefaultVfs(), size, bytes);
}
int Sleep(sqlite3_vfs* /*vfs*/, int microseconds) {
  return DefaultVfs()->xSleep(DefaultVfs(), microseconds);
}
int CurrentTime(sqlite3_vfs* /*vfs*/, double* time) {
  return DefaultVfs()->xCurrentTime(DefaultVfs(), time);
}
int GetLastError(sqlite3_vfs* /*vfs*/, int size, char* message) {
  return DefaultVfs()->xGetLastError(DefaultVfs(), size, message);
}

sqlite3_vfs MakeVfs() {
  sqlite3_vfs vfs{};
  vfs.iVersion = 1;
  vfs.szOsFile = sizeof(ChecksumFile);
  vfs.mxPathname = DefaultVfs()->mxPathname;
  vfs.zName = kChecksumVfs;
  vfs.xOpen = Open;
  vfs.xDelete = Delete;
  vfs.xAccess = Access;
  vfs.xFullPathname = FullPathname;
  vfs.xRandomness = Randomness;
  vfs.xSleep = Sleep;
  vfs.xCurrentTime = CurrentTime;
  vfs.xGetLastError = GetLastError;
  return vfs;
}

}  // namespace

void RegisterChecksumVfs() {
  static sqlite3_vfs* const vfs = [] {
    sqlite3_initialize();
    static sqlite3_vfs registered = MakeVfs();
    sqlite3_vfs_register(&registered, /*makeDflt=*/0);
    return &registered;
  }();
  static_cast<void>(vfs);
}

std::string TakePageDamage() {
  return std::exchange(page_damage, std::string());
}

}  // namespace cohort
