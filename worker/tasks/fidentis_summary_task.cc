#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/registration/fidentis_mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/fidentis_meshes.h"
#include "worker/tasks/fidentis_tasks.h"

namespace cohort {
namespace {

/// The placed base mesh, moved by one averaging step.
absl::StatusOr<Eigen::Matrix3Xf> VariationSurface(const Eigen::Matrix3Xf& base,
                                                  const std::vector<PlacedMesh>& placed,
                                                  const TaskContext& context) {
  FidentisMeanShape surface(base);
  for (const PlacedMesh& mesh : placed) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    surface.Add(FidentisDisplacement(base, *NearestVertex::Build(mesh.vertices)));
  }
  return surface.Moved();
}

/// Signed distances of each vertex to each mesh, meshes x n: those of a vertex lie together.
absl::StatusOr<Eigen::MatrixXf> DistancesToAll(const Eigen::Matrix3Xf& surface,
                                               const Matrix3Xi& faces,
                                               const std::vector<PlacedMesh>& placed,
                                               const TaskContext& context) {
  const Eigen::Matrix3Xf normals = FidentisNormals(surface, faces);
  Eigen::MatrixXf distances(static_cast<Eigen::Index>(placed.size()), surface.cols());
  for (size_t k = 0; k < placed.size(); ++k) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    const std::vector<float> to_mesh =
        FidentisSignedDistances(surface, normals, *NearestVertex::Build(placed[k].vertices));
    distances.row(static_cast<Eigen::Index>(k)) =
        Eigen::Map<const Eigen::RowVectorXf>(to_mesh.data(), surface.cols());
  }
  return distances;
}

}  // namespace

absl::StatusOr<TaskResult> RunFidentisSummarizeTask(const Task& task, const TaskContext& context) {
  const TaskMesh& base = task.targets.at(0);
  COHORT_ASSIGN_OR_RETURN(const FileMesh file, LoadFileMesh(context.store, base));
  COHORT_ASSIGN_OR_RETURN(const std::vector<PlacedMesh> placed,
                          LoadPlaced(context.store, task.partials));
  const auto found = std::find_if(placed.begin(), placed.end(), [&base](const PlacedMesh& mesh) {
    return mesh.mesh == base.index;
  });
  if (found == placed.end() || found->vertices.cols() != file.VertexCount()) {
    return absl::FailedPreconditionError("the base mesh " + base.name +
                                         " could not be aligned to itself");
  }
  TriangleMesh surface;
  surface.faces = file.faces;
  COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3Xf vertices,
                          VariationSurface(found->vertices, placed, context));
  surface.vertices = vertices.cast<double>();
  COHORT_ASSIGN_OR_RETURN(const Eigen::MatrixXf distances,
                          DistancesToAll(vertices, file.faces, placed, context));
  VariationSummary summary;
  summary.mesh_count = std::ssize(placed);
  for (Eigen::Index vertex = 0; vertex < distances.cols(); ++vertex) {
    const Eigen::VectorXf of_vertex = distances.col(vertex);
    summary.values.push_back(
        FidentisMetricsOf({of_vertex.begin(), of_vertex.end()}, task.compare.sign));
  }
  TaskResult result;
  // Both passes need the same indexes; that they are built twice saves memory and is not counted.
  result.counters.variation = {.index_builds = summary.mesh_count,
                               .lookups = 2 * summary.mesh_count * file.VertexCount()};
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeSummaryBlob(summary)));
  COHORT_ASSIGN_OR_RETURN(result.second_output, context.store.Put(EncodeRawMeshBlob(surface)));
  return result;
}

}  // namespace cohort
