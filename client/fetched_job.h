#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/session.h"
#include "common/analysis/metric_matrix.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/jobs/blobs.h"

namespace cohort {

/// Everything of a job that its files are made from.
struct FetchedJob {
  Job job;
  std::vector<JobMesh> meshes;
  std::vector<MeshAlignment> alignments;
  std::vector<MeshAlignment> poses;
  LargeMatrix matrix;                ///< Of the meshes that were not rejected, symmetrised.
  std::vector<std::string> persons;  ///< One per row of the matrix.
  TriangleMesh mean_shape;
  TriangleMesh variation_shape;
  std::vector<std::string> unmeasured;  ///< Meshes whose values of all others are NaN.
  VariationSummary variation;
  BaseChoice base_choice;  ///< Without candidates if the base was given.
};

/// Fetches all of it from the server.
/// @param metric  another metric than the job's, or empty.
/// @return kFailedPrecondition if the job has not succeeded.
[[nodiscard]] absl::StatusOr<FetchedJob> FetchJob(Session& session,
                                                  const JobId& id,
                                                  std::optional<Metric> metric);

/// The mesh of each row of the matrix, as an index into `meshes`.
[[nodiscard]] std::vector<size_t> MeshesOfRows(const FetchedJob& fetched);

/// Where the reference is from there: of each mesh of the job; the identity for those without an
/// alignment (method none).
[[nodiscard]] std::vector<Similarity> TransformsOf(const FetchedJob& fetched);

/// The mesh that the job worked with: canonical, or its symmetric copy. Thread-safe.
/// @param mesh  index into `meshes`, of one that was not rejected.
/// @return kNotFound if the server no longer has it; kDataLoss if it is damaged.
[[nodiscard]] absl::StatusOr<TriangleMesh> FetchJobMesh(Session& session,
                                                        const FetchedJob& fetched,
                                                        size_t mesh);

}  // namespace cohort
