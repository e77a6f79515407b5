#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/jobs/job_state.h"

namespace cohort {

/// The label of a set's mesh that names whose face it is.
inline constexpr std::string_view kPersonLabel = "person";

/// "ok" or "rejected".
[[nodiscard]] std::string_view MeshStatus(const JobMesh& mesh);

/// The person of each of `names`; an empty string where no mesh of that name has a person.
[[nodiscard]] std::vector<std::string> PersonsOf(std::span<const std::string> names,
                                                 std::span<const JobMesh> meshes);

/// The rows and columns of the meshes that were not rejected.
/// @param values  over all meshes of the job.
[[nodiscard]] MetricMatrix WithoutRejected(const RowMajorMatrix& values,
                                           std::span<const JobMesh> meshes);

}  // namespace cohort
