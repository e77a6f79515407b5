#include "client/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

absl::Status ErrnoStatus(int error, const std::string& what) {
  const std::string message = what + ": " + std::generic_category().message(error);
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return absl::NotFoundError(message);
    case EACCES:
    case EPERM:
    case EROFS:
      return absl::PermissionDeniedError(message);
    case ENOSPC:
    case EDQUOT:
      return absl::ResourceExhaustedError(message);
    default:
      return absl::UnknownError(message);
  }
}

bool HasMeshExtension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".obj" || extension == ".ply" || extension == ".stl";
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) {
      close(fd_);
    }
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int Get() const { return fd_; }

 private:
  int fd_;
};

absl::Status WriteAll(int fd, std::string_view bytes, const std::string& what) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written < 0) {
      return ErrnoStatus(errno, what);
    }
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<fs::path>> ListMeshFiles(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file() && HasMeshExtension(it->path())) {
      files.push_back(it->path());
    }
  }
  if (error) {
    return ErrnoStatus(error.value(), "folder " + folder.string());
  }
  if (files.empty()) {
    return absl::FailedPreconditionError("folder " + folder.string() +
                                         " has no .obj, .ply or .stl file");
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return a.filename().string() < b.filename().string();
  });
  return files;
}

absl::StatusOr<FileDigest> HashFile(const fs::path& file) {
  const Descriptor in(open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (in.Get() < 0) {
    return ErrnoStatus(errno, "file " + file.string());
  }
  Sha256 hash;
  FileDigest result;
  std::string buffer(1 << 20, '\0');
  while (true) {
    const ssize_t got = read(in.Get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) {
      continue;
    }
    if (got < 0) {
      return ErrnoStatus(errno, "file " + file.string());
    }
    if (got == 0) {
      break;
    }
    hash.Update(std::string_view(buffer).substr(0, static_cast<size_t>(got)));
    result.size_bytes += got;
  }
  result.digest = hash.Finish();
  return result;
}

absl::StatusOr<std::string> ReadWholeFile(const fs::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  if (!in || fs::is_directory(file) || !(bytes << in.rdbuf())) {
    if (in && fs::is_regular_file(file) && fs::file_size(file) == 0) {
      return std::string();
    }
    return ErrnoStatus(errno != 0 ? errno : EISDIR, "file " + file.string());
  }
  return bytes.str();
}

absl::StatusOr<FileWriter> FileWriter::Create(const fs::path& file) {
  const fs::path aside = file.parent_path() / absl::StrCat(".", file.filename().string(), ".new");
  const int descriptor = open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC,
                              S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  FileWriter writer(file, aside, descriptor);
  if (descriptor < 0) {
    return ErrnoStatus(errno, writer.What());
  }
  return writer;
}

FileWriter::FileWriter(fs::path file, fs::path aside, int descriptor)
    : file_(std::move(file)), aside_(std::move(aside)), descriptor_(descriptor) {}

FileWriter::FileWriter(FileWriter&& other) noexcept
    : file_(std::move(other.file_)),
      aside_(std::move(other.aside_)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

FileWriter::~FileWriter() {
  if (descriptor_ >= 0) {
    close(descriptor_);
    unlink(aside_.c_str());
  }
}

std::string FileWriter::What() const {
  return "cannot write " + file_.string();
}

absl::Status FileWriter::Append(std::string_view bytes) {
  return WriteAll(descriptor_, bytes, What());
}

absl::Status FileWriter::Finish() {
  // Some file systems report a full disk only here.
  if (fsync(descriptor_) != 0 || rename(aside_.c_str(), file_.c_str()) != 0) {
    return ErrnoStatus(errno, What());
  }
  close(std::exchange(descriptor_, -1));
  return absl::OkStatus();
}

absl::Status WriteWholeFile(const fs::path& file, std::string_view bytes) {
  COHORT_ASSIGN_OR_RETURN(FileWriter writer, FileWriter::Create(file));
  COHORT_RETURN_IF_ERROR(writer.Append(bytes));
  return writer.Finish();
}

absl::Status PrepareFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return ErrnoStatus(error.value(), "output folder " + folder.string());
  }
  const fs::path probe = folder / ".cohort-probe";
  COHORT_RETURN_IF_ERROR(WriteWholeFile(probe, "probe"));
  fs::remove(probe, error);
  return absl::OkStatus();
}

}  // namespace cohort
