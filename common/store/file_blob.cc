#include "common/store/file_blob.h"

#include <fcntl.h>
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

#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"
#include "common/store/install_blob.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

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
    COHORT_ASSIGN_OR_RETURN(IncomingFile incoming, End());
    const absl::Status installed = InstallBlobFiles(std::span(&incoming, 1), root_, durability_);
    NoteInstalled(incoming);
    COHORT_RETURN_IF_ERROR(installed);
    return incoming.digest;
  }

  /// Commit in parts: what is to be given to InstallBlobFiles,
  [[nodiscard]] absl::StatusOr<IncomingFile> End() {
    assert(!committed_);
    committed_ = true;
    COHORT_RETURN_IF_ERROR(appended_);
    return IncomingFile{.file = file_, .path = incoming_, .digest = hash_.Finish()};
  }
  /// and what has come of it.
  void NoteInstalled(const IncomingFile& incoming) { renamed_ = incoming.became_blob; }

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

absl::StatusOr<std::unique_ptr<FileBlobWriter>> StartWriter(const fs::path& root,
                                                            Durability durability) {
  fs::path incoming = UniqueIncomingPath(root);
  COHORT_ASSIGN_OR_RETURN(FileDescriptor file,
                          OpenFile(incoming, O_WRONLY | O_CREAT | O_EXCL, 0600));
  return std::make_unique<FileBlobWriter>(std::move(file), std::move(incoming), root, durability);
}

/// A name that no other writer uses, on this machine or another: the process, a count in it, and 64
/// random bits for machines that share the root over a network.
std::string UniqueName() {
  static std::atomic<int64_t> count{0};
  static const uint64_t drawn = [] {
    std::random_device random;
    return (static_cast<uint64_t>(random()) << 32) | random();
  }();
  return absl::StrCat(::getpid(), "-", count++, "-", drawn);
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
  return StartWriter(root, durability);
}

absl::StatusOr<std::vector<Digest>> WriteBlobFiles(const fs::path& root,
                                                   std::span<const std::string_view> blobs,
                                                   Durability durability) {
  std::vector<std::unique_ptr<FileBlobWriter>> writers;
  std::vector<IncomingFile> files;
  std::vector<Digest> digests;
  for (const std::string_view blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(auto writer, StartWriter(root, durability));
    COHORT_RETURN_IF_ERROR(writer->Append(blob));
    COHORT_ASSIGN_OR_RETURN(const IncomingFile file, writer->End());
    files.push_back(file);
    digests.push_back(file.digest);
    writers.push_back(std::move(writer));
  }
  const absl::Status installed = InstallBlobFiles(files, root, durability);
  for (size_t i = 0; i < files.size(); ++i) {
    writers[i]->NoteInstalled(files[i]);
  }
  COHORT_RETURN_IF_ERROR(installed);
  return digests;
}

}  // namespace cohort
