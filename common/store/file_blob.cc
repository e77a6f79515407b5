#include "common/store/file_blob.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <random>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPieceBytes = 1 << 20;

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
    damage_ = WithUnreadableBlob(
        absl::DataLossError("blob file " + path_.string() + " is damaged: " + why), digest_);
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

/// Makes a whole written file the blob of its digest, durably. A good blob that is there is kept
/// and made young.
/// @return whether `incoming` has become the blob; if not, it is still there.
absl::StatusOr<bool> Install(const FileDescriptor& file,
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

class FileBlobWriter final : public BlobWriter {
 public:
  FileBlobWriter(FileDescriptor file, fs::path incoming, fs::path root, Durability durability)
      : file_(std::move(file)),
        incoming_(std::move(incoming)),
        root_(std::move(root)),
        durability_(durability) {}

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
    const Digest digest = hash_.Finish();
    COHORT_ASSIGN_OR_RETURN(renamed_, Install(file_, incoming_, root_, digest, durability_));
    return digest;
  }

 private:
  FileDescriptor file_;
  fs::path incoming_;
  fs::path root_;
  Durability durability_;
  Sha256 hash_;
  absl::Status appended_;  ///< The first failure: a file with a hole is never committed.
  bool committed_ = false;
  bool renamed_ = false;
};

/// Goes on with the file of an upload, which it has locked.
class UploadWriter final : public BlobWriter {
 public:
  UploadWriter(FileDescriptor file, fs::path path, fs::path root, Digest digest)
      : file_(std::move(file)),
        path_(std::move(path)),
        root_(std::move(root)),
        digest_(std::move(digest)) {}

  /// Reads what is there already.
  [[nodiscard]] absl::Status ReadBegin() {
    std::string piece(static_cast<size_t>(kPieceBytes), '\0');
    while (true) {
      COHORT_ASSIGN_OR_RETURN(const int64_t count,
                              ReadUpTo(file_, piece.data(), kPieceBytes, path_));
      hash_.Update(std::string_view(piece).substr(0, static_cast<size_t>(count)));
      size_ += count;
      if (count < kPieceBytes) {
        return absl::OkStatus();
      }
    }
  }
  [[nodiscard]] int64_t Size() const { return size_; }

  [[nodiscard]] absl::Status Append(std::string_view bytes) override {
    COHORT_RETURN_IF_ERROR(appended_);
    appended_ = WriteAll(file_, bytes, path_);
    if (!appended_.ok()) {
      // Half a piece may be there: it is taken back, and tried again when there is space.
      if (::ftruncate(file_.Get(), size_) != 0) {
        ::unlink(path_.c_str());
      }
      return appended_;
    }
    hash_.Update(bytes);
    size_ += std::ssize(bytes);
    return absl::OkStatus();
  }

  [[nodiscard]] absl::StatusOr<Digest> Commit() override {
    COHORT_RETURN_IF_ERROR(appended_);
    const Digest found = hash_.Finish();
    if (found != digest_) {
      ::unlink(path_.c_str());
      return WithReason(
          absl::DataLossError(absl::StrCat("the bytes sent have the SHA-256 ", found.Hex(),
                                           ", announced was ", digest_.Hex(), "; send them again")),
          "UPLOAD_DAMAGED");
    }
    COHORT_ASSIGN_OR_RETURN(const bool is_renamed,
                            Install(file_, path_, root_, digest_, Durability::kSynced));
    if (!is_renamed) {
      ::unlink(path_.c_str());
    }
    return digest_;
  }

 private:
  FileDescriptor file_;
  fs::path path_;
  fs::path root_;
  Digest digest_;
  Sha256 hash_;
  int64_t size_ = 0;
  absl::Status appended_;
};

absl::Status UploadBusy(const Digest& digest) {
  return WithReason(
      absl::AbortedError("the upload of " + digest.Hex() + " is going on over another connection"),
      "UPLOAD_BUSY");
}

/// A name that no other writer uses, on this machine or another: the process, a count in it, and 64
/// random bits for machines that share the root over a network.
std::string UniqueName() {
  static std::atomic<int64_t> count{0};
  std::random_device random;
  return std::to_string(::getpid()) + "-" + std::to_string(count++) + "-" +
         std::to_string((static_cast<uint64_t>(random()) << 32) | random());
}

}  // namespace

fs::path BlobsFolder(const fs::path& root) {
  return root / "sha256";
}

fs::path IncomingFolder(const fs::path& root) {
  return root / "incoming";
}

fs::path BlobPath(const fs::path& root, const Digest& digest) {
  return BlobsFolder(root) / digest.Hex().substr(0, 2) / digest.Hex();
}

fs::path UniqueIncomingPath(const fs::path& root) {
  return IncomingFolder(root) / UniqueName();
}

fs::path UploadPath(const fs::path& root, const Digest& digest) {
  return IncomingFolder(root) / ("upload-" + digest.Hex());
}

absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlobFile(const fs::path& root,
                                                         const Digest& digest) {
  const fs::path path = BlobPath(root, digest);
  absl::StatusOr<FileDescriptor> file = OpenFile(path, O_RDONLY);
  if (!file.ok()) {
    if (::access(path.c_str(), F_OK) == 0 || errno != ENOENT) {
      return file.status();
    }
    return WithUnreadableBlob(
        absl::NotFoundError("blob '" + digest.Hex() + "' is not in " + root.string()), digest);
  }
  struct stat status {};
  if (::fstat(file->Get(), &status) != 0) {
    return ErrnoStatus(errno, "stat", path);
  }
  return std::make_unique<FileBlobReader>(*std::move(file), status.st_size, digest, path);
}

absl::StatusOr<std::unique_ptr<BlobWriter>> StartBlobFile(const fs::path& root,
                                                          Durability durability) {
  fs::path incoming = UniqueIncomingPath(root);
  COHORT_ASSIGN_OR_RETURN(FileDescriptor file,
                          OpenFile(incoming, O_WRONLY | O_CREAT | O_EXCL, 0600));
  return std::make_unique<FileBlobWriter>(std::move(file), std::move(incoming), root, durability);
}

absl::StatusOr<std::unique_ptr<BlobWriter>> ResumeBlobFile(const fs::path& root,
                                                           const Digest& digest,
                                                           int64_t offset) {
  const fs::path path = UploadPath(root, digest);
  COHORT_ASSIGN_OR_RETURN(FileDescriptor file, OpenFile(path, O_RDWR | O_CREAT, 0600));
  if (::flock(file.Get(), LOCK_EX | LOCK_NB) != 0) {
    return UploadBusy(digest);
  }
  // Between open and lock another writer may have made the file a blob, or removed it.
  struct stat ours {};
  struct stat named {};
  if (::fstat(file.Get(), &ours) != 0 || ::stat(path.c_str(), &named) != 0 ||
      ours.st_ino != named.st_ino) {
    return UploadBusy(digest);
  }
  auto writer = std::make_unique<UploadWriter>(std::move(file), path, root, digest);
  COHORT_RETURN_IF_ERROR(writer->ReadBegin());
  if (writer->Size() != offset) {
    return WithReason(
        absl::OutOfRangeError(absl::StrCat("the upload of ", digest.Hex(), " goes on at byte ",
                                           writer->Size(), ", not at ", offset)),
        "WRONG_OFFSET");
  }
  return writer;
}

}  // namespace cohort
