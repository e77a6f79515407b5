#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/labels_csv.h"
#include "client/session.h"

namespace cohort {

/// A mesh file and what the server will know of it.
struct MeshFile {
  std::filesystem::path path;
  SetMesh mesh;
};

/// Hashes `files` and joins their labels; empty files and names used twice are refused.
/// @return naming the file; kInvalidArgument if `labels` is not empty and names none of the files.
[[nodiscard]] absl::StatusOr<std::vector<MeshFile>> DescribeFiles(
    const std::vector<std::filesystem::path>& files, const Labels& labels);

struct UploadCounts {
  int64_t sent = 0;
  int64_t known = 0;  ///< The server had the bytes already.
};

/// Puts the files into the set; only bytes that the server does not have travel.
[[nodiscard]] absl::StatusOr<UploadCounts> Upload(Session& session,
                                                  const std::string& set,
                                                  const std::vector<MeshFile>& files);

}  // namespace cohort
