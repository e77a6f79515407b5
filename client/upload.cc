#include "client/upload.h"

#include <set>
#include <utility>

#include "client/files.h"
#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/base/utf8.h"

namespace cohort {
namespace {

/// Adds a mesh whose bytes the server has; sends them if it has lost them meanwhile.
absl::Status AddUploaded(Session& session, const std::string& set, const MeshFile& file) {
  absl::Status added = session.Persist([&] { return session.AddMesh(set, file.mesh, ""); });
  if (ErrorReason(added) != "BLOB_MISSING") {
    return added;
  }
  COHORT_RETURN_IF_ERROR(session.UploadFile(file.mesh, file.path.string()));
  return session.AddMesh(set, file.mesh, "");
}

}  // namespace

absl::StatusOr<std::vector<MeshFile>> DescribeFiles(const std::vector<std::filesystem::path>& files,
                                                    const Labels& labels) {
  std::vector<MeshFile> described;
  std::set<std::string> names;
  int64_t labelled = 0;
  for (const std::filesystem::path& path : files) {
    COHORT_ASSIGN_OR_RETURN(const FileDigest hashed, HashFile(path));
    MeshFile file{.path = path, .mesh = {}};
    file.mesh.name = path.filename().string();
    file.mesh.raw = hashed.digest;
    file.mesh.size_bytes = hashed.size_bytes;
    if (!IsValidUtf8(file.mesh.name)) {
      return absl::InvalidArgumentError("file name '" + PrintableUtf8(file.mesh.name) +
                                        "' is not UTF-8; rename the file (convmv -t utf8)");
    }
    if (!names.insert(file.mesh.name).second) {
      return absl::InvalidArgumentError("two files are named " + file.mesh.name +
                                        "; names must be unique in a set");
    }
    const auto found = labels.find(file.mesh.name);
    if (found != labels.end()) {
      file.mesh.labels = found->second;
      ++labelled;
    }
    described.push_back(std::move(file));
  }
  if (!labels.empty() && labelled == 0) {
    return absl::InvalidArgumentError("none of the " + std::to_string(labels.size()) +
                                      " files in the labels (such as '" + labels.begin()->first +
                                      "') is among the meshes; column 'file' must hold file names "
                                      "without folders");
  }
  return described;
}

absl::StatusOr<UploadCounts> Upload(Session& session,
                                    const std::string& set,
                                    const std::vector<MeshFile>& files) {
  std::vector<Digest> digests;
  digests.reserve(files.size());
  for (const MeshFile& file : files) {
    digests.push_back(file.mesh.raw);
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<Digest> missing, session.FindMissing(digests));
  std::set<Digest> to_send(missing.begin(), missing.end());
  UploadCounts counts;
  for (const MeshFile& file : files) {
    const bool send = to_send.erase(file.mesh.raw) > 0;
    if (send) {
      COHORT_RETURN_IF_ERROR(session.UploadFile(file.mesh, file.path.string()));
    }
    COHORT_RETURN_IF_ERROR(AddUploaded(session, set, file));
    ++(send ? counts.sent : counts.known);
  }
  return counts;
}

}  // namespace cohort
