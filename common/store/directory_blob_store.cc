#include "common/store/directory_blob_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

fs::path DamagedFolder(const fs::path& root) {
  return root / "damaged";
}

double AgeOf(const struct stat& status) {
  const auto written = std::chrono::seconds(status.st_mtim.tv_sec) +
                       std::chrono::nanoseconds(status.st_mtim.tv_nsec);
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch() -
                                       written)
      .count();
}

/// Puts a file back under its name, unless another has come there meanwhile.
absl::Status PutBack(const fs::path& moved, const fs::path& path) {
  if (::link(moved.c_str(), path.c_str()) != 0 && errno != EEXIST) {
    if (::rename(moved.c_str(), path.c_str()) != 0) {  // No hard links on this file system.
      return ErrnoStatus(errno, "rename to " + path.string(), moved);
    }
    return absl::OkStatus();
  }
  ::unlink(moved.c_str());  // A failure leaves it to SweepIncoming.
  return absl::OkStatus();
}

/// A file of a blob folder, for Visit. Empty digest: it is no blob, or has just gone.
StoredBlob Describe(const fs::path& file) {
  struct stat status {};
  const absl::StatusOr<Digest> digest = Digest::FromHex(file.filename().string());
  if (!digest.ok() || ::lstat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return {};
  }
  return {.digest = *digest, .size_bytes = status.st_size, .age_seconds = AgeOf(status)};
}

}  // namespace

absl::StatusOr<std::unique_ptr<DirectoryBlobStore>> DirectoryBlobStore::Create(
    const std::filesystem::path& given_root, Durability durability) {
  std::error_code error;
  const fs::path root = fs::absolute(given_root, error).lexically_normal();
  if (!error) {
    fs::create_directories(root, error);
  }
  if (error) {
    return ErrnoStatus(error.value(), "create the folder", given_root);
  }
  for (const fs::path& folder : {IncomingFolder(root), DamagedFolder(root), BlobsFolder(root)}) {
    COHORT_RETURN_IF_ERROR(EnsureFolder(folder));
  }
  // All folders now, and durable: a blob written later needs only its own folder synced, also when
  // another process made that folder a moment ago.
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  for (const char first : kHexDigits) {
    for (const char second : kHexDigits) {
      COHORT_RETURN_IF_ERROR(EnsureFolder(BlobsFolder(root) / std::string{first, second}));
    }
  }
  if (durability == Durability::kSynced) {
    COHORT_RETURN_IF_ERROR(SyncFolder(BlobsFolder(root)));
    COHORT_RETURN_IF_ERROR(SyncFolder(root));
  }
  return std::unique_ptr<DirectoryBlobStore>(new DirectoryBlobStore(root, durability));
}

absl::StatusOr<std::unique_ptr<BlobWriter>> DirectoryBlobStore::StartPut() {
  return StartBlobFile(root_, durability_);
}

absl::StatusOr<std::unique_ptr<BlobReader>> DirectoryBlobStore::Open(const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const bool there, Contains(digest));
  if (!there) {
    return WithUnreadableBlob(
        absl::NotFoundError("blob '" + digest.Hex() + "' is not in " + root_.string()), digest);
  }
  return OpenBlobFile(root_, digest);
}

absl::StatusOr<bool> DirectoryBlobStore::Contains(const Digest& digest) {
  if (digest.empty()) {
    return false;
  }
  const fs::path path = BlobPath(root_, digest);
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    return S_ISREG(status.st_mode);
  }
  if (errno == ENOENT) {
    return false;
  }
  return ErrnoStatus(errno, "stat", path);
}

absl::StatusOr<std::vector<Digest>> DirectoryBlobStore::PutAll(
    std::span<const std::string_view> blobs) {
  return WriteBlobFiles(root_, blobs, durability_);
}

absl::Status DirectoryBlobStore::Visit(
    const std::function<absl::Status(const StoredBlob&)>& visit) {
  std::error_code error;
  for (fs::directory_iterator folder(BlobsFolder(root_), error);
       !error && folder != fs::directory_iterator(); folder.increment(error)) {
    std::error_code no_folder;  // Whatever people put there is not ours.
    for (fs::directory_iterator file(folder->path(), no_folder);
         !no_folder && file != fs::directory_iterator(); file.increment(no_folder)) {
      const StoredBlob blob = Describe(file->path());
      if (!blob.digest.empty()) {
        COHORT_RETURN_IF_ERROR(visit(blob));
      }
    }
  }
  return error ? ErrnoStatus(error.value(), "list", BlobsFolder(root_)) : absl::OkStatus();
}

absl::StatusOr<StoreSpace> DirectoryBlobStore::Space() {
  struct statvfs status {};
  if (::statvfs(root_.c_str(), &status) != 0) {
    return ErrnoStatus(errno, "ask for the free space", root_);
  }
  const auto unit = static_cast<int64_t>(status.f_frsize);
  return StoreSpace{.free_bytes = static_cast<int64_t>(status.f_bavail) * unit,
                    .total_bytes = static_cast<int64_t>(status.f_blocks) * unit};
}

absl::StatusOr<bool> DirectoryBlobStore::Renew(const Digest& digest) {
  if (digest.empty()) {
    return false;
  }
  if (::utimensat(AT_FDCWD, BlobPath(root_, digest).c_str(), nullptr, 0) == 0) {
    return true;
  }
  // Another user's file on a shared folder keeps its age: rather an early collection, which is
  // found and mended, than an error.
  return Contains(digest);
}

absl::StatusOr<bool> DirectoryBlobStore::RemoveIfOlder(const Digest& digest, double age_seconds) {
  if (digest.empty()) {
    return false;
  }
  const fs::path path = BlobPath(root_, digest);
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || AgeOf(status) < age_seconds) {
    return false;
  }
  // Moved aside first and looked at again: whoever has just made it young finds it in its place.
  const fs::path moved = UniqueIncomingPath(root_);
  if (::rename(path.c_str(), moved.c_str()) != 0) {
    return errno == ENOENT ? absl::StatusOr<bool>(false)
                           : ErrnoStatus(errno, "rename to " + moved.string(), path);
  }
  if (::stat(moved.c_str(), &status) == 0 && AgeOf(status) < age_seconds) {
    COHORT_RETURN_IF_ERROR(PutBack(moved, path));
    return false;
  }
  if (::unlink(moved.c_str()) != 0 && errno != ENOENT) {
    return ErrnoStatus(errno, "remove", moved);
  }
  return true;
}

absl::Status DirectoryBlobStore::Quarantine(const Digest& digest) {
  const fs::path path = BlobPath(root_, digest);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(
                           std::chrono::system_clock::now().time_since_epoch())
                           .count();
  const fs::path kept = DamagedFolder(root_) / (digest.Hex() + "-" + std::to_string(seconds));
  if (::rename(path.c_str(), kept.c_str()) != 0 && errno != ENOENT) {
    return ErrnoStatus(errno, "rename to " + kept.string(), path);
  }
  return SyncFolder(path.parent_path());
}

absl::StatusOr<int64_t> DirectoryBlobStore::UploadedBytes(const Digest& digest) {
  const fs::path path = UploadPath(root_, digest);
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    return status.st_size;
  }
  if (errno == ENOENT) {
    return 0;
  }
  return ErrnoStatus(errno, "stat", path);
}

absl::StatusOr<std::unique_ptr<BlobWriter>> DirectoryBlobStore::ResumePut(const Digest& digest,
                                                                          int64_t offset) {
  if (digest.empty()) {
    return absl::InvalidArgumentError("an upload needs the SHA-256 of its bytes");
  }
  return ResumeBlobFile(root_, digest, offset);
}

absl::Status DirectoryBlobStore::SweepIncoming(double age_seconds) {
  const auto latest =
      fs::file_time_type::clock::now() - std::chrono::duration_cast<fs::file_time_type::duration>(
                                             std::chrono::duration<double>(age_seconds));
  const fs::path incoming = IncomingFolder(root_);
  std::error_code error;
  fs::directory_iterator file(incoming, error);
  for (; !error && file != fs::directory_iterator(); file.increment(error)) {
    // Another process may finish or sweep the file at any moment: what is gone is as it should be.
    std::error_code gone;
    const fs::file_time_type written = fs::last_write_time(file->path(), gone);
    if (!gone && written < latest && !fs::remove(file->path(), gone) && gone) {
      return ErrnoStatus(gone.value(), "remove", file->path());
    }
  }
  return error ? ErrnoStatus(error.value(), "list", incoming) : absl::OkStatus();
}

}  // namespace cohort
