#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/report/job_json.h"

namespace cohort {

/// Writes one file after the other into a folder that is there, and remembers what each is.
class FolderWriter {
 public:
  explicit FolderWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// @return the status of `bytes`; as WriteWholeFile.
  [[nodiscard]] absl::Status Write(const ResultFile& file,
                                   const absl::StatusOr<std::string>& bytes) {
    COHORT_RETURN_IF_ERROR(bytes.status());
    files_.push_back(file);
    return WriteWholeFile(folder_ / file.name, *bytes);
  }
  /// A file that a function writes, given its path.
  [[nodiscard]] absl::Status Write(
      const ResultFile& file,
      const std::function<absl::Status(const std::filesystem::path&)>& write) {
    files_.push_back(file);
    return write(folder_ / file.name);
  }
  /// A file that was written by others.
  void Note(const ResultFile& file) { files_.push_back(file); }
  /// Takes away what another job may have left under this name, so that it is not taken for ours.
  void LeaveOut(const std::string& name) const {
    std::error_code absent;
    std::filesystem::remove(folder_ / name, absent);
  }
  [[nodiscard]] const std::filesystem::path& Folder() const { return folder_; }
  [[nodiscard]] const std::vector<ResultFile>& Files() const { return files_; }

 private:
  std::filesystem::path folder_;
  std::vector<ResultFile> files_;
};

}  // namespace cohort
