#include "common/store/install_blob.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPieceBytes = 1 << 20;

/// Reads all of it. OK only if the file is there and has its digest.
absl::Status VerifyBlobFile(const fs::path& root, const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobReader> reader, OpenBlobFile(root, digest));
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const std::string piece, reader->Read(kPieceBytes));
    if (piece.empty()) {
      return absl::OkStatus();
    }
  }
}

}  // namespace

absl::StatusOr<bool> InstallBlobFile(const FileDescriptor& file,
                                     const fs::path& incoming,
                                     const fs::path& root,
                                     const Digest& digest,
                                     Durability durability) {
  if (::fchmod(file.Get(), 0444) != 0) {
    return ErrnoStatus(errno, "make read-only", incoming);
  }
  if (durability == Durability::kSynced && ::fdatasync(file.Get()) != 0) {
    return ErrnoStatus(errno, "sync", incoming);
  }
  const fs::path path = BlobPath(root, digest);
  // A blob that is there is read before it is kept: a task that is run again because its output was
  // found damaged must mend it. Only bytes that are written twice pay for this. One that cannot be
  // made young (another user's, or just removed) is replaced.
  const bool is_kept =
      VerifyBlobFile(root, digest).ok() && ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0) == 0;
  if (!is_kept && ::rename(incoming.c_str(), path.c_str()) != 0) {
    return ErrnoStatus(errno, "rename to " + path.string(), incoming);
  }
  if (durability == Durability::kSynced) {
    // Also for a blob that was there: its writer may have died before this.
    COHORT_RETURN_IF_ERROR(SyncFolder(path.parent_path()));
  }
  return !is_kept;
}

}  // namespace cohort
