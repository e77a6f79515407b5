#pragma once

#include <filesystem>
#include <optional>

#include <absl/status/statusor.h>

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

/// Fetches the results of a job that succeeded and writes its files into `folder`.
/// @param metric  another metric than the job's, or empty.
/// @return kFailedPrecondition if the job has not succeeded; as WriteWholeFile.
[[nodiscard]] absl::StatusOr<ResultsDigest> WriteResults(Session& session,
                                                         const JobId& id,
                                                         std::optional<Metric> metric,
                                                         const std::filesystem::path& folder);

}  // namespace cohort
