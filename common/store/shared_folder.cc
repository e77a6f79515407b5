#include "common/store/decoded_mesh_folder.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

#include <spdlog/spdlog.h>
#include <Eigen/Core>

#include "common/base/status_macros.h"
#include "common/store/file_blob.h"
#include "common/store/posix_file.h"

namespace cohort {
namespace {

constexpr double kDeadWriterSeconds = 24 * 3600;
constexpr unsigned int kFileMode = 0444;

/// What stands before the numbers of a file:
///   64 bytes  SHA-256, in hexadecimal, of the blob's digest and all that follows
///   uint64 n, uint64 m, then n x 3 float32 (x y z), m x 3 int32
constexpr size_t kCheckBytes = 64;
using Counts = std::array<uint64_t, 2>;

template <typename T>
std::string_view BytesOf(const T& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()),
          static_cast<size_t>(numbers.size()) * sizeof(*numbers.data())};
}

/// A file's bytes as the memory that the system has them in: a copy would cost as much as the rest.
class MappedFile {
 public:
  /// @return kNotFound, as ErrnoStatus. An empty file is a damaged one: kDataLoss.
  static absl::StatusOr<MappedFile> Open(const std::filesystem::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 && errno == ENOENT) {
      return absl::NotFoundError("");
    }
    COHORT_ASSIGN_OR_RETURN(const FileDescriptor file, OpenFile(path, O_RDONLY));
    if (::fstat(file.Get(), &status) != 0) {
      return ErrnoStatus(errno, "stat", path);
    }
    const auto size = static_cast<size_t>(status.st_size);
    if (size == 0) {
      return absl::DataLossError("an empty file");
    }
    void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file.Get(), 0);
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

/// Of bytes that Keep wrote for this blob, unchanged; nothing of any others.
std::optional<TriangleMesh> Decode(const Digest& blob, std::string_view bytes) {
  const std::string_view check = bytes.substr(0, kCheckBytes);
  const std::string_view rest = bytes.substr(check.size());
  Sha256 hash;
  hash.Update(blob.Hex());
  hash.Update(rest);
  Counts counts = {};
  if (hash.Finish().Hex() != check || rest.size() < sizeof(counts)) {
    return std::nullopt;
  }
  std::memcpy(counts.data(), rest.data(), sizeof(counts));
  const char* numbers = rest.data() + sizeof(counts);
  TriangleMesh mesh;
  Eigen::Matrix3Xf vertices(3, static_cast<Eigen::Index>(counts[0]));
  mesh.faces.resize(3, static_cast<Eigen::Index>(counts[1]));
  if (rest.size() != sizeof(counts) + BytesOf(vertices).size() + BytesOf(mesh.faces).size()) {
    return std::nullopt;
  }
  // The bytes are those that were written, so the numbers are, too.
  std::memcpy(vertices.data(), numbers, BytesOf(vertices).size());
  std::memcpy(mesh.faces.data(), numbers + BytesOf(vertices).size(), BytesOf(mesh.faces).size());
  mesh.vertices = vertices.cast<double>();
  return mesh;
}

}  // namespace

absl::StatusOr<std::unique_ptr<DecodedMeshFolder>> DecodedMeshFolder::Create(
    const std::filesystem::path& folder, int64_t max_bytes) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryBlobStore> files,
                          DirectoryBlobStore::Create(folder, Durability::kFast));
  COHORT_RETURN_IF_ERROR(files->SweepIncoming(kDeadWriterSeconds));
  std::unique_ptr<DecodedMeshFolder> made(new DecodedMeshFolder(std::move(files), max_bytes));
  COHORT_RETURN_IF_ERROR(made->limit_.Start());
  return made;
}

std::optional<TriangleMesh> DecodedMeshFolder::Get(const Digest& blob) {
  const absl::StatusOr<MappedFile> file = MappedFile::Open(BlobPath(files_->Root(), blob));
  if (absl::IsNotFound(file.status())) {
    return std::nullopt;
  }
  if (!file.ok()) {
    Drop(blob, std::string(file.status().message()));
    return std::nullopt;
  }
  std::optional<TriangleMesh> mesh = Decode(blob, file->Bytes());
  if (!mesh) {
    Drop(blob, "its bytes have changed");
    return std::nullopt;
  }
  const absl::StatusOr<bool> renewed = files_->Renew(blob);
  if (!renewed.ok()) {  // It goes earlier than it should.
    spdlog::debug("event=decoded_mesh_not_renewed error=\"{}\"",
                  std::string(renewed.status().message()));
  }
  return mesh;
}

void DecodedMeshFolder::Keep(const Digest& blob, const TriangleMesh& mesh) {
  const Eigen::Matrix3Xf vertices = mesh.vertices.cast<float>();
  if (vertices.cast<double>() != mesh.vertices) {
    return;
  }
  const Counts counts = {static_cast<uint64_t>(mesh.VertexCount()),
                         static_cast<uint64_t>(mesh.FaceCount())};
  const std::array pieces = {BytesOf(counts), BytesOf(vertices), BytesOf(mesh.faces)};
  const auto size =
      static_cast<int64_t>(kCheckBytes + pieces[0].size() + pieces[1].size() + pieces[2].size());
  if (size > limit_.MaxBytes()) {
    return;
  }
  if (const absl::Status written = Write(blob, pieces); !written.ok()) {
    spdlog::warn("event=decoded_mesh_not_kept error=\"{}\"", std::string(written.message()));
    return;
  }
  limit_.NoteAdded(size);
}

absl::Status DecodedMeshFolder::Write(const Digest& blob,
                                      std::span<const std::string_view> pieces) {
  Sha256 hash;
  hash.Update(blob.Hex());
  for (const std::string_view piece : pieces) {
    hash.Update(piece);
  }
  const std::filesystem::path path = BlobPath(files_->Root(), blob);
  const std::filesystem::path aside = UniqueIncomingPath(files_->Root());
  COHORT_ASSIGN_OR_RETURN(const FileDescriptor file,
                          OpenFile(aside, O_WRONLY | O_CREAT | O_EXCL, kFileMode));
  absl::Status written = WriteAll(file, hash.Finish().Hex(), aside);
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

void DecodedMeshFolder::Drop(const Digest& blob, const std::string& why) {
  spdlog::warn("event=decoded_mesh_dropped blob={} error=\"{}\"", blob.Hex(), why);
  const absl::Status removed = files_->Remove(blob);
  if (!removed.ok()) {  // It is found damaged again, or replaced.
    spdlog::warn("event=decoded_mesh_stands error=\"{}\"", std::string(removed.message()));
  }
}

}  // namespace cohort
