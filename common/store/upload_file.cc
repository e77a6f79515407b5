// Uploads that are gone on with; file_blob.h has what is promised.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/store/file_blob.h"
#include "common/store/install_blob.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kPieceBytes = 1 << 20;

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
    IncomingFile incoming{.file = file_, .path = path_, .digest = digest_};
    COHORT_RETURN_IF_ERROR(InstallBlobFiles(std::span(&incoming, 1), root_, Durability::kSynced));
    if (!incoming.became_blob) {
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

}  // namespace

fs::path UploadPath(const fs::path& root, const Digest& digest) {
  return IncomingFolder(root) / ("upload-" + digest.Hex());
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
