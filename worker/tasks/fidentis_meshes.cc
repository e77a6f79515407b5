#include "worker/tasks/fidentis_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/distance_codec.h"
#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

FidentisIcpOptions IcpOptionsOf(const IcpOptions& options) {
  FidentisIcpOptions fidentis;
  fidentis.scale =
      options.scale_mode == ScaleMode::kOff ? FidentisScale::kOff : FidentisScale::kFromX;
  fidentis.max_iterations = options.max_iterations;
  fidentis.tolerance = static_cast<float>(options.tolerance);
  return fidentis;
}

/// RMS and mean of the distances to the nearest vertices: for the report, which the predecessor
/// does not have.
void MeasureResiduals(const Eigen::Matrix3Xf& moved,
                      const NearestVertex& target,
                      Alignment& alignment) {
  std::vector<int32_t> nearest(static_cast<size_t>(moved.cols()));
  std::vector<float> squared_distances(nearest.size());
  target.Find(moved, nearest, squared_distances);
  double sum = 0;
  double sum_of_squares = 0;
  for (const float squared : squared_distances) {
    sum += std::sqrt(double{squared});
    sum_of_squares += double{squared};
  }
  const auto count = static_cast<double>(moved.cols());
  alignment.mean_residual = sum / count;
  alignment.rms_residual = std::sqrt(sum_of_squares / count);
}

}  // namespace

absl::StatusOr<FileMesh> LoadFileMesh(BlobStore& store, const TaskMesh& mesh) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(mesh.blob));
  absl::StatusOr<FileMesh> file = DecodeFileMeshBlob(bytes);
  if (!file.ok()) {
    return absl::Status(file.status().code(), mesh.name + ", blob " + mesh.blob.Hex() + ": " +
                                                  std::string(file.status().message()));
  }
  return file;
}

absl::StatusOr<FidentisReference> LoadFidentisReference(BlobStore& store, const Digest& blob) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(blob));
  FidentisReference reference;
  if (IsFileMeshBlob(bytes)) {
    COHORT_ASSIGN_OR_RETURN(FileMesh file, DecodeFileMeshBlob(bytes));
    reference.vertices = FidentisCentered(file.vertices.cast<double>());
    reference.faces = std::move(file.faces);
    return reference;
  }
  COHORT_ASSIGN_OR_RETURN(TriangleMesh shape, DecodeMeshBlob(bytes));
  if (shape.VertexCount() == 0 || !shape.vertices.allFinite()) {
    return absl::DataLossError("mesh blob " + blob.Hex() + ": no vertices, or not finite");
  }
  reference.vertices = shape.vertices.cast<float>();  // They are float32 already.
  reference.faces = std::move(shape.faces);
  return reference;
}

absl::StatusOr<std::vector<PlacedMesh>> LoadPlaced(BlobStore& store,
                                                   const std::vector<Digest>& blobs) {
  std::vector<PlacedMesh> all;
  for (const Digest& blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(std::vector<PlacedMesh> some, DecodePlacedBlob(bytes));
    std::move(some.begin(), some.end(), std::back_inserter(all));
  }
  return all;
}

FidentisStart CenteredStart(const FileMesh& file) {
  const Eigen::Matrix3Xd vertices = file.vertices.cast<double>();
  FidentisStart start;
  start.vertices = FidentisCentered(vertices);
  start.T_start_file.translation = -FidentisCenter(vertices).cast<double>();
  return start;
}

absl::StatusOr<FidentisAligned> AlignFidentis(const FidentisStart& start,
                                              const NearestVertex& target,
                                              const IcpOptions& options) {
  COHORT_ASSIGN_OR_RETURN(FidentisAlignment fit,
                          AlignByFidentisIcp(start.vertices, target, IcpOptionsOf(options)));
  FidentisAligned aligned;
  aligned.moved = std::move(fit.moved);
  Alignment& alignment = aligned.alignment;
  alignment.T_target_source = fit.T_target_source * start.T_start_file;
  alignment.iterations = static_cast<int>(fit.steps.size());
  alignment.converged = fit.converged;
  alignment.lookups = fit.lookups;
  alignment.overlap = std::numeric_limits<double>::quiet_NaN();
  MeasureResiduals(aligned.moved, target, alignment);
  return aligned;
}

Eigen::Matrix3Xf FidentisNormalsOf(const FileMesh& file, const Eigen::Matrix3Xf& moved) {
  return file.HasNormals() ? file.normals : FidentisNormals(moved, file.faces);
}

MetricValues FidentisMetricsOf(const std::vector<float>& signed_distances, DistanceSign sign) {
  const FidentisMetricValues floats =
      sign == DistanceSign::kSigned ? ComputeFidentisMetrics(signed_distances)
                                    : ComputeFidentisMetrics(FidentisAbsolute(signed_distances));
  MetricValues metrics{};
  static_assert(kMetricCount == kFidentisMetricCount);
  std::copy(floats.begin(), floats.end(), metrics.begin());
  return metrics;
}

MeasuredPair MeasureFidentis(const std::vector<float>& signed_distances,
                             const CompareOptions& options) {
  MeasuredPair measured;
  measured.metrics = FidentisMetricsOf(signed_distances, options.sign);
  measured.field.values = std::ssize(signed_distances);
  if (options.retention == Retention::kVectors) {
    measured.field.bytes = EncodeVectors(signed_distances);
  }
  return measured;
}

}  // namespace cohort
