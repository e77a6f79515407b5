#include "common/store/directory_blob_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/status_macros.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPieceBytes = 1 << 20;

fs::path BlobsFolder(const fs::path& root) {
  return root / "sha256";
}

fs::path IncomingFolder(const fs::path& root) {
  return root / "incoming";
}

/// Where the blob of `digest` (not empty) is under `root`.
fs::path BlobPath(const fs::path& root, const Digest& digest) {
  return BlobsFolder(root) / digest.Hex().substr(0, 2) / digest.Hex();
}

/// A name that no other writer of this root uses, on this machine or another: the process, a count
/// in it, and 64 random bits for machines that share the root over a network.
std::string UniqueName() {
  static std::atomic<int64_t> count{0};
  std::random_device random;
  return std::to_string(::getpid()) + "-" + std::to_string(count++) + "-" +
         std::to_string((static_cast<uint64_t>(random()) << 32) | random());
}

/// Hashes what it hands out, so that a damaged file is found where it is read.
class FileBlobReader final : public BlobReader {
 public:
  FileBlobReader(FileDescriptor file, int64_t size_bytes, Digest digest, fs::path path)
      : file_(std::move(file)),
        remaining_(size_bytes),
        size_bytes_(size_bytes),
        digest_(std::move(digest)),
        path_(std::move(path)) {}

  [[nodiscard]] int64_t SizeBytes() const override { return size_bytes_; }

  /// The digest is checked before the last piece is given away: a caller that stops after
  /// SizeBytes() bytes has verified bytes too.
  [[nodiscard]] absl::StatusOr<std::string> Read(int64_t max_bytes) override {
    assert(max_bytes > 0);
    COHORT_RETURN_IF_ERROR(damage_);
    if (ended_) {
      return std::string();
    }
    const int64_t wanted = std::min(max_bytes, remaining_);
    std::string piece(static_cast<size_t>(wanted), '\0');
    COHORT_ASSIGN_OR_RETURN(const int64_t count, ReadUpTo(file_, piece.data(), wanted, path_));
    remaining_ -= count;
    if (count < wanted) {
      return Damaged("cut short, " + std::to_string(remaining_) + " bytes are missing");
    }
    hash_.Update(piece);
    if (remaining_ == 0) {
      COHORT_RETURN_IF_ERROR(CheckEnd());
    }
    return piece;
  }

 private:
  [[nodiscard]] absl::Status CheckEnd() {
    char next = 0;
    COHORT_ASSIGN_OR_RETURN(const int64_t more, ReadUpTo(file_, &next, 1, path_));
    if (more > 0) {
      return Damaged("grown beyond " + std::to_string(size_bytes_) + " bytes");
    }
    ended_ = true;
    const Digest found = hash_.Finish();
    if (found != digest_) {
      return Damaged("its bytes have the SHA-256 " + found.Hex());
    }
    return absl::OkStatus();
  }

  /// Remembers the damage: no later Read looks like a good end.
  [[nodiscard]] absl::Status Damaged(const std::string& why) {
    damage_ = absl::DataLossError("blob file " + path_.string() + " is damaged: " + why);
    return damage_;
  }

  FileDescriptor file_;
  int64_t remaining_;
  int64_t size_bytes_;
  Digest digest_;
  fs::path path_;
  Sha256 hash_;
  bool ended_ = false;
  absl::Status damage_;
};

absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlobFile(const fs::path& path,
                                                         const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(FileDescriptor file, OpenFile(path, O_RDONLY));
  struct stat status {};
  if (::fstat(file.Get(), &status) != 0) {
    return ErrnoStatus(errno, "stat", path);
  }
  return std::make_unique<FileBlobReader>(std::move(file), status.st_size, digest, path);
}

/// Reads all of it. OK only if the file is there and has its digest.
absl::Status VerifyBlobFile(const fs::path& path, const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobReader> reader, OpenBlobFile(path, digest));
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const std::string piece, reader->Read(kPieceBytes));
    if (piece.empty()) {
      return absl::OkStatus();
    }
  }
}

/// Writes ROOT/incoming/NAME; the file is gone after the writer unless Commit renamed it.
class FileBlobWriter final : public BlobWriter {
 public:
  FileBlobWriter(FileDescriptor file, fs::path incoming, fs::path root)
      : file_(std::move(file)), incoming_(std::move(incoming)), root_(std::move(root)) {}

  ~FileBlobWriter() override {
    if (!renamed_) {
      ::unlink(incoming_.c_str());  // A failure leaves it to SweepIncoming.
    }
  }

  FileBlobWriter(const FileBlobWriter&) = delete;
  FileBlobWriter& operator=(const FileBlobWriter&) = delete;

  [[nodiscard]] absl::Status Append(std::string_view bytes) override {
    assert(!committed_);
    COHORT_RETURN_IF_ERROR(appended_);
    hash_.Update(bytes);
    appended_ = WriteAll(file_, bytes, incoming_);
    return appended_;
  }

  [[nodiscard]] absl::StatusOr<Digest> Commit() override {
    assert(!committed_);
    committed_ = true;
    COHORT_RETURN_IF_ERROR(appended_);
    if (::fchmod(file_.Get(), 0444) != 0) {
      return ErrnoStatus(errno, "make read-only", incoming_);
    }
    if (::fdatasync(file_.Get()) != 0) {
      return ErrnoStatus(errno, "sync", incoming_);
    }
    const Digest digest = hash_.Finish();
    const fs::path path = BlobPath(root_, digest);
    // A blob that is there is read before it is kept: a task that is run again because its output
    // was found damaged must mend it. Only bytes that are written twice pay for this.
    if (!VerifyBlobFile(path, digest).ok()) {
      if (::rename(incoming_.c_str(), path.c_str()) != 0) {
        return ErrnoStatus(errno, "rename to " + path.string(), incoming_);
      }
      renamed_ = true;
    }
    // Also for a blob that was there: its writer may have died before this.
    COHORT_RETURN_IF_ERROR(SyncFolder(path.parent_path()));
    return digest;
  }

 private:
  FileDescriptor file_;
  fs::path incoming_;
  fs::path root_;
  Sha256 hash_;
  absl::Status appended_;  ///< The first failure: a file with a hole is never committed.
  bool committed_ = false;
  bool renamed_ = false;
};

}  // namespace

absl::StatusOr<std::unique_ptr<DirectoryBlobStore>> DirectoryBlobStore::Create(
    const std::filesystem::path& given_root) {
  std::error_code error;
  const fs::path root = fs::absolute(given_root, error).lexically_normal();
  if (!error) {
    fs::create_directories(root, error);
  }
  if (error) {
    return ErrnoStatus(error.value(), "create the folder", given_root);
  }
  COHORT_RETURN_IF_ERROR(EnsureFolder(IncomingFolder(root)));
  COHORT_RETURN_IF_ERROR(EnsureFolder(BlobsFolder(root)));
  // All folders now, and durable: a blob written later needs only its own folder synced, also when
  // another process made that folder a moment ago.
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  for (const char first : kHexDigits) {
    for (const char second : kHexDigits) {
      COHORT_RETURN_IF_ERROR(EnsureFolder(BlobsFolder(root) / std::string{first, second}));
    }
  }
  for (const fs::path& folder : {BlobsFolder(root), root}) {
    COHORT_RETURN_IF_ERROR(SyncFolder(folder));
  }
  return std::unique_ptr<DirectoryBlobStore>(new DirectoryBlobStore(root));
}

absl::StatusOr<std::unique_ptr<BlobWriter>> DirectoryBlobStore::StartPut() {
  fs::path incoming = IncomingFolder(root_) / UniqueName();
  COHORT_ASSIGN_OR_RETURN(FileDescriptor file,
                          OpenFile(incoming, O_WRONLY | O_CREAT | O_EXCL, 0600));
  return std::make_unique<FileBlobWriter>(std::move(file), std::move(incoming), root_);
}

absl::StatusOr<std::unique_ptr<BlobReader>> DirectoryBlobStore::Open(const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const bool there, Contains(digest));
  if (!there) {
    return absl::NotFoundError("blob '" + digest.Hex() + "' is not in " + root_.string());
  }
  return OpenBlobFile(PathOf(digest), digest);
}

absl::StatusOr<bool> DirectoryBlobStore::Contains(const Digest& digest) {
  if (digest.empty()) {
    return false;
  }
  const fs::path path = PathOf(digest);
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    return S_ISREG(status.st_mode);
  }
  if (errno == ENOENT) {
    return false;
  }
  return ErrnoStatus(errno, "stat", path);
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

std::filesystem::path DirectoryBlobStore::PathOf(const Digest& digest) const {
  return BlobPath(root_, digest);
}

}  // namespace cohort
