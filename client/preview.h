#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "client/session.h"

namespace cohort {

/// Fetches the preview of a job, which may still run, and writes preview_matrix.csv and
/// preview_heatmap.png into `folder`.
/// @return their number of meshes; kFailedPrecondition if the job makes no preview or has not come
///         to it; as WriteWholeFile.
[[nodiscard]] absl::StatusOr<int64_t> WritePreview(Session& session,
                                                   const Job& job,
                                                   const std::filesystem::path& folder);

/// Whether the job has a preview by now and its exact matrix is still to come.
[[nodiscard]] bool HasFreshPreview(const Job& job);

}  // namespace cohort
