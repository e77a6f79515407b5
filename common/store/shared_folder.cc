#include "common/store/shared_folder.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <iterator>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/base/gmac.h"
#include "common/base/status_macros.h"
#include "common/store/file_blob.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

constexpr double kDeadWriterSeconds = 24 * 3600;
constexpr unsigned int kFileMode = 0444;

/// What stands before the bytes of a file: their check, repeated, so that they begin at an address
/// that vectors may be read from.
constexpr size_t kCheckBytes = 64;

/// Of the name, too: a file under another name is not whole.
std::string CheckOf(const Digest& name, std::span<const std::string_view> pieces) {
  Gmac gmac;
  gmac.Update(name.Hex());
  for (const std::string_view piece : pieces) {
    gmac.Update(piece);
  }
  const std::string once = gmac.Finish();
  std::string check;
  while (check.size() < kCheckBytes) {
    check += once;
  }
  return check;
}

/// A file's bytes as the memory that the system has them in: a copy would cost as much as the rest.
class MappedFile {
 public:
  /// @return kNotFound, as ErrnoStatus. An empty file is a damaged one: kDataLoss.
  static absl::StatusOr<MappedFile> Open(const std::filesystem::path& path) {
    const absl::StatusOr<FileDescriptor> file = OpenFile(path, O_RDONLY);
    if (!file.ok()) {
      const bool is_there = ::access(path.c_str(), F_OK) == 0 || errno != ENOENT;
      return is_there ? file.status() : absl::NotFoundError("");
    }
    struct stat status {};
    if (::fstat(file->Get(), &status) != 0) {
      return ErrnoStatus(errno, "stat", path);
    }
    const auto size = static_cast<size_t>(status.st_size);
    if (size == 0) {
      return absl::DataLossError("an empty file");
    }
    void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file->Get(), 0);
    if (bytes == MAP_FAILED) {
      return ErrnoStatus(errno, "map", path);
    }
    return MappedFile(static_cast<const char*>(bytes), size);
  }
  ~MappedFile() {
    if (bytes_ != nullptr) {
      ::munmap(const_cast<char*>(bytes_), size_);
    }
  }
  MappedFile(MappedFile&& other) noexcept
      : bytes_(std::exchange(other.bytes_, nullptr)), size_(other.size_) {}
  MappedFile& operator=(MappedFile&&) = delete;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::string_view Bytes() const { return {bytes_, size_}; }

 private:
  MappedFile(const char* bytes, size_t size) : bytes_(bytes), size_(size) {}

  const char* bytes_;
  size_t size_;
};

/// Whether Keep wrote these under this name.
bool IsWhole(const Digest& name, std::string_view bytes) {
  const std::string_view check = bytes.substr(0, kCheckBytes);
  const std::string_view kept = bytes.substr(check.size());
  return CheckOf(name, std::span(&kept, 1)) == check;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SharedFolder>> SharedFolder::Create(
    const std::filesystem::path& folder, int64_t max_bytes) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryBlobStore> files,
                          DirectoryBlobStore::Create(folder, Durability::kFast));
  COHORT_RETURN_IF_ERROR(files->SweepIncoming(kDeadWriterSeconds));
  std::unique_ptr<SharedFolder> made(new SharedFolder(std::move(files), max_bytes));
  COHORT_RETURN_IF_ERROR(made->limit_.Start());
  return made;
}

bool SharedFolder::Get(const Digest& name, const std::function<void(std::string_view)>& read) {
  const absl::StatusOr<MappedFile> file = MappedFile::Open(BlobPath(files_->Root(), name));
  if (absl::IsNotFound(file.status())) {
    return false;
  }
  if (!file.ok()) {
    Drop(name, std::string(file.status().message()));
    return false;
  }
  if (!IsWhole(name, file->Bytes())) {
    Drop(name, "its bytes have changed");
    return false;
  }
  read(file->Bytes().substr(kCheckBytes));
  const absl::StatusOr<bool> renewed = files_->Renew(name);
  if (!renewed.ok()) {  // It goes earlier than it should.
    spdlog::debug("event=shared_not_renewed error=\"{}\"", std::string(renewed.status().message()));
  }
  return true;
}

void SharedFolder::Keep(const Digest& name, std::span<const std::string_view> pieces) {
  auto size = static_cast<int64_t>(kCheckBytes);
  for (const std::string_view piece : pieces) {
    size += std::ssize(piece);
  }
  if (size > limit_.MaxBytes()) {
    return;
  }
  if (const absl::Status written = Write(name, pieces); !written.ok()) {
    spdlog::warn("event=shared_not_kept error=\"{}\"", std::string(written.message()));
    return;
  }
  limit_.NoteAdded(size);
}

absl::Status SharedFolder::Write(const Digest& name, std::span<const std::string_view> pieces) {
  const std::filesystem::path path = BlobPath(files_->Root(), name);
  const std::filesystem::path aside = UniqueIncomingPath(files_->Root());
  COHORT_ASSIGN_OR_RETURN(const FileDescriptor file,
                          OpenFile(aside, O_WRONLY | O_CREAT | O_EXCL, kFileMode));
  absl::Status written = WriteAll(file, CheckOf(name, pieces), aside);
  for (const std::string_view piece : pieces) {
    written = written.ok() ? WriteAll(file, piece, aside) : written;
  }
  if (written.ok() && ::rename(aside.c_str(), path.c_str()) != 0) {
    written = ErrnoStatus(errno, "rename to " + path.string(), aside);
  }
  if (!written.ok()) {
    ::unlink(aside.c_str());  // A failure leaves it to SweepIncoming.
  }
  return written;
}

void SharedFolder::Drop(const Digest& name, const std::string& why) {
  spdlog::warn("event=shared_dropped name={} error=\"{}\"", name.Hex(), why);
  const absl::Status removed = files_->Remove(name);
  if (!removed.ok()) {  // It is found damaged again, or replaced.
    spdlog::warn("event=shared_stands error=\"{}\"", std::string(removed.message()));
  }
}

}  // namespace cohort
