#pragma once

#include <cstdint>
#include <span>

#include <absl/status/statusor.h>

#include "client/session.h"
#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Directed values of the meshes that were not rejected; NaN where nothing was measured.
/// @param meshes  of the job, in its order.
/// @return kDataLoss if the server sends values of other meshes.
[[nodiscard]] absl::StatusOr<LargeMatrix> FetchMatrix(Session& session,
                                                      const JobId& id,
                                                      Metric metric,
                                                      std::span<const JobMesh> meshes);

/// The preview of those meshes, symmetric.
/// @return as FetchMatrix; kFailedPrecondition if there is none (yet).
[[nodiscard]] absl::StatusOr<LargeMatrix> FetchPreview(Session& session,
                                                       const JobId& id,
                                                       std::span<const JobMesh> meshes);

/// Puts the values of a part into their places.
/// @param row_of  of each mesh of the job; -1: none, its values are left out.
/// @return kDataLoss if the part names a mesh that the job does not have.
[[nodiscard]] absl::Status PutPart(const MatrixPart& part,
                                   std::span<const int64_t> row_of,
                                   Eigen::Ref<RowMajorMatrix> matrix);

}  // namespace cohort
