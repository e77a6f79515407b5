#pragma once

#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/fetched_job.h"
#include "client/session.h"
#include "common/base/executor.h"
#include "common/report/matrix_description.h"

namespace cohort {

/// report.html of a job. Up to 300 meshes, of 10 million vertices together, have thumbnails, for
/// which their meshes are fetched.
/// @param notes  what people must know of the results.
/// @return as ReportHtml. A mesh that cannot be fetched only lacks its thumbnail.
[[nodiscard]] absl::StatusOr<std::string> MakeReport(
    Session& session,
    const FetchedJob& fetched,
    const MatrixDescription& description,
    const std::vector<std::vector<Neighbour>>& neighbours,
    const std::vector<std::string>& notes,
    Executor& executor);

}  // namespace cohort
