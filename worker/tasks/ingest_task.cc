#include "worker/tasks/ingest_task.h"

#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/mesh_warnings.h"
#include "common/pairs/canonical_mesh.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

/// What a file became.
struct Ingested {
  std::string blob;
  TriangleMesh mesh;  ///< What the blob decodes to.
  IngestedMesh summary;
};

void Describe(Ingested& ingested) {
  ingested.summary.vertices = ingested.mesh.VertexCount();
  ingested.summary.faces = ingested.mesh.FaceCount();
  const Eigen::Vector3d centroid = CentroidOf(ingested.mesh.vertices);
  ingested.summary.centroid = {centroid.x(), centroid.y(), centroid.z()};
}

absl::StatusOr<Ingested> IngestCanonical(std::string_view bytes,
                                         const std::string& name,
                                         int position_bits) {
  COHORT_ASSIGN_OR_RETURN(CanonicalMesh canonical, MakeCanonical(bytes, name, position_bits));
  Ingested ingested{
      .blob = std::move(canonical.blob), .mesh = std::move(canonical.mesh), .summary = {}};
  ingested.summary.health = std::move(canonical.health);
  Describe(ingested);
  return ingested;
}

/// Vertices that get no normal from file or faces.
int64_t CountWithoutNormal(const FileMesh& file) {
  if (file.HasNormals()) {
    return 0;
  }
  return FidentisNormals(file.vertices, file.faces).array().isNaN().colwise().any().count();
}

/// Bytes of a file in, the same mesh out, for the predecessor's arithmetic.
absl::StatusOr<Ingested> KeepAsInFile(std::string_view bytes, const std::string& name) {
  COHORT_ASSIGN_OR_RETURN(const FileMesh file, ReadFileMesh(bytes, name));
  TriangleMesh checked;
  checked.vertices = file.vertices.cast<double>();
  checked.faces = file.faces;
  Ingested ingested;
  MeshHealth& health = ingested.summary.health;
  if (const absl::Status status = CheckAndClean(checked, health); !status.ok()) {
    return absl::Status(status.code(), name + ": " + std::string(status.message()));
  }
  if (health.point_cloud && !file.HasNormals()) {
    return absl::InvalidArgumentError(name +
                                      ": a point cloud without normals (vn): the distances of the "
                                      "preset fidentis have a sign, which needs faces or normals");
  }
  health.warnings = MeshWarnings(checked, health, Mending::kKept);
  if (const int64_t count = CountWithoutNormal(file); count > 0) {
    health.warnings.push_back(std::to_string(count) +
                              " vertices without a normal (in no face, or in one without area): "
                              "as in the predecessor, all distances of this mesh are NaN");
  }
  ingested.blob = EncodeFileMeshBlob(file);
  ingested.mesh.vertices = file.vertices.cast<double>();
  ingested.mesh.faces = file.faces;
  Describe(ingested);
  return ingested;
}

}  // namespace

absl::StatusOr<TaskResult> RunIngestTask(const Task& task, const TaskContext& context) {
  TaskResult result;
  std::vector<std::string> blobs;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(input.blob));
    absl::StatusOr<Ingested> ingested =
        task.position_bits == 0 ? KeepAsInFile(bytes, input.name)
                                : IngestCanonical(bytes, input.name, task.position_bits);
    if (!ingested.ok()) {
      // The reason may quote the file, and a file may hold anything.
      result.rejections.push_back(
          {.index = input.index,
           .reason = PrintableUtf8(std::string(ingested.status().message()))});
      continue;
    }
    ingested->summary.index = input.index;
    ingested->summary.blob = Sha256::Of(ingested->blob);
    context.meshes.Keep(ingested->summary.blob, std::move(ingested->mesh));
    result.ingested.push_back(std::move(ingested->summary));
    blobs.push_back(std::move(ingested->blob));
  }
  std::vector<TaskBlob> written;
  written.reserve(blobs.size());
  for (size_t i = 0; i < blobs.size(); ++i) {
    written.push_back({blobs[i], result.ingested[i].blob});
  }
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

}  // namespace cohort
