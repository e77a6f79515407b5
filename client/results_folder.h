#pragma once

#include <filesystem>
#include <optional>

#include <absl/status/statusor.h>

#include "client/mesh_export.h"
#include "client/session.h"

namespace cohort {

/// What of a job's results is for the screen.
struct ResultsDigest {
  Job job;
  std::vector<JobMesh> meshes;
  std::vector<std::string> files;  ///< Names in the folder, the first ones to look at first.
  std::vector<std::string> notes;  ///< What people must know of the results; one line each.
  /// With persons: meshes whose nearest mesh is the same person, and meshes that have another one.
  int64_t nearest_same_person = 0;
  int64_t with_same_person = 0;
};

/// What is written besides the tables and pictures that always are.
struct ResultsOptions {
  enum class Report { kWrite, kLeaveOut };
  std::optional<Metric> metric = std::nullopt;  ///< Another metric than the job's.
  Report report = Report::kWrite;               ///< report.html.
  std::optional<MeshFormat> aligned_meshes =
      std::nullopt;  ///< All meshes in the job's frame, in "aligned".
};

/// Fetches the results of a job that succeeded and writes its files into `folder`.
/// @return kFailedPrecondition if the job has not succeeded; as WriteWholeFile.
[[nodiscard]] absl::StatusOr<ResultsDigest> WriteResults(Session& session,
                                                         const JobId& id,
                                                         const ResultsOptions& options,
                                                         const std::filesystem::path& folder);

}  // namespace cohort
