#include "common/store/install_blob.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <set>
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

absl::Status SyncFiles(std::span<const IncomingFile> files) {
  // Begun for all before any is waited for, so that they get into one commit of the journal.
  for (const IncomingFile& incoming : files) {
    (void)::sync_file_range(incoming.file.Get(), 0, 0, SYNC_FILE_RANGE_WRITE);  // A hint.
  }
  for (const IncomingFile& incoming : files) {
    if (::fdatasync(incoming.file.Get()) != 0) {
      return ErrnoStatus(errno, "sync", incoming.path);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status InstallBlobFiles(std::span<IncomingFile> files,
                              const fs::path& root,
                              Durability durability) {
  for (const IncomingFile& incoming : files) {
    if (::fchmod(incoming.file.Get(), 0444) != 0) {
      return ErrnoStatus(errno, "make read-only", incoming.path);
    }
  }
  if (durability == Durability::kSynced) {
    COHORT_RETURN_IF_ERROR(SyncFiles(files));
  }
  std::set<fs::path> folders;
  for (IncomingFile& incoming : files) {
    const fs::path path = BlobPath(root, incoming.digest);
    // A blob that is there is read before it is kept: a task that is run again because its output
    // was found damaged must mend it. Only bytes that are written twice pay for this. One that
    // cannot be made young (another user's, or just removed) is replaced.
    const bool is_kept = VerifyBlobFile(root, incoming.digest).ok() &&
                         ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0) == 0;
    if (!is_kept && ::rename(incoming.path.c_str(), path.c_str()) != 0) {
      return ErrnoStatus(errno, "rename to " + path.string(), incoming.path);
    }
    incoming.became_blob = !is_kept;
    // Also for a blob that was there: its writer may have died before this.
    folders.insert(path.parent_path());
  }
  if (durability == Durability::kSynced) {
    for (const fs::path& folder : folders) {
      COHORT_RETURN_IF_ERROR(SyncFolder(folder));
    }
  }
  return absl::OkStatus();
}

}  // namespace cohort
