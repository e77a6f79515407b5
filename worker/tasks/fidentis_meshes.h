#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/mesh/file_mesh.h"
#include "common/geometry/nearest/nearest_vertex.h"
#include "common/geometry/registration/fidentis_icp.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/jobs/placed_blob.h"
#include "common/jobs/task.h"
#include "common/pairs/pair_meter.h"
#include "common/store/blob_store.h"

namespace cohort {

// What the tasks of Arithmetic::kFidentis share.

/// @return as BlobStore::Get and DecodeFileMeshBlob, naming the mesh.
[[nodiscard]] absl::StatusOr<FileMesh> LoadFileMesh(BlobStore& store, const TaskMesh& mesh);

/// What meshes are moved to: a mean shape as it is, a mesh of a file about the middle of its box.
struct FidentisReference {
  Eigen::Matrix3Xf vertices;
  Matrix3Xi faces;
};
[[nodiscard]] absl::StatusOr<FidentisReference> LoadFidentisReference(BlobStore& store,
                                                                      const Digest& blob);

/// All meshes of these placed blobs, in their order.
[[nodiscard]] absl::StatusOr<std::vector<PlacedMesh>> LoadPlaced(BlobStore& store,
                                                                 const std::vector<Digest>& blobs);

/// A mesh on its way: where an alignment begins.
struct FidentisStart {
  Eigen::Matrix3Xf vertices;
  Similarity T_start_file;
};
/// The mesh of a file, centred.
[[nodiscard]] FidentisStart CenteredStart(const FileMesh& file);

/// One alignment and what is reported of it.
struct FidentisAligned {
  Eigen::Matrix3Xf moved;
  Alignment alignment;  ///< From the file; residuals after the last step; overlap NaN: not known.
};
/// @return as AlignByFidentisIcp.
[[nodiscard]] absl::StatusOr<FidentisAligned> AlignFidentis(const FidentisStart& start,
                                                            const NearestVertex& target,
                                                            const IcpOptions& options);

/// The normals that give the distances of a moved mesh their signs: those of the file, if it has
/// them, as they are there; else those of the moved faces.
[[nodiscard]] Eigen::Matrix3Xf FidentisNormalsOf(const FileMesh& file,
                                                 const Eigen::Matrix3Xf& moved);

/// Metrics and field of one directed pair.
/// @param signed_distances  at least one.
[[nodiscard]] MeasuredPair MeasureFidentis(const std::vector<float>& signed_distances,
                                           const CompareOptions& options);

/// The metrics of signed distances, or of them without their signs.
[[nodiscard]] MetricValues FidentisMetricsOf(const std::vector<float>& signed_distances,
                                             DistanceSign sign);

}  // namespace cohort
