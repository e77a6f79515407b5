#include "worker/tasks/ingest_task.h"

#include <string>
#include <utility>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/mesh_warnings.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

struct CanonicalMesh {
  std::string blob;
  IngestedMesh summary;
};

/// Bytes of a file in, canonical mesh out; every error is the file's fault.
absl::StatusOr<CanonicalMesh> MakeCanonical(std::string_view bytes,
                                            const std::string& name,
                                            int position_bits) {
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, ReadMesh(bytes, name));
  CanonicalMesh canonical;
  MeshHealth& health = canonical.summary.health;
  if (const absl::Status checked = CheckAndClean(mesh, health); !checked.ok()) {
    return absl::Status(checked.code(), name + ": " + std::string(checked.message()));
  }
  COHORT_ASSIGN_OR_RETURN(canonical.blob,
                          EncodeDracoMeshBlob(mesh, {.position_bits = position_bits}));
  // The decoded mesh is the mesh from now on: Draco rounds coordinates and reorders vertices.
  COHORT_ASSIGN_OR_RETURN(mesh, DecodeMeshBlob(canonical.blob));
  canonical.summary.vertices = mesh.VertexCount();
  canonical.summary.faces = mesh.FaceCount();
  const Eigen::Vector3d centroid = CentroidOf(mesh.vertices);
  canonical.summary.centroid = {centroid.x(), centroid.y(), centroid.z()};
  return canonical;
}

/// Vertices that get no normal from file or faces.
int64_t CountWithoutNormal(const FileMesh& file) {
  if (file.HasNormals()) {
    return 0;
  }
  return FidentisNormals(file.vertices, file.faces).array().isNaN().colwise().any().count();
}

/// Bytes of a file in, the same mesh out, for the predecessor's arithmetic.
absl::StatusOr<CanonicalMesh> KeepAsInFile(std::string_view bytes, const std::string& name) {
  COHORT_ASSIGN_OR_RETURN(const FileMesh file, ReadFileMesh(bytes, name));
  TriangleMesh checked;
  checked.vertices = file.vertices.cast<double>();
  checked.faces = file.faces;
  CanonicalMesh canonical;
  MeshHealth& health = canonical.summary.health;
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
  canonical.blob = EncodeFileMeshBlob(file);
  canonical.summary.vertices = file.VertexCount();
  canonical.summary.faces = file.faces.cols();
  const Eigen::Vector3d centroid = CentroidOf(file.vertices.cast<double>());
  canonical.summary.centroid = {centroid.x(), centroid.y(), centroid.z()};
  return canonical;
}

}  // namespace

absl::StatusOr<TaskResult> RunIngestTask(const Task& task, const TaskContext& context) {
  TaskResult result;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(input.blob));
    absl::StatusOr<CanonicalMesh> canonical =
        task.position_bits == 0 ? KeepAsInFile(bytes, input.name)
                                : MakeCanonical(bytes, input.name, task.position_bits);
    if (!canonical.ok()) {
      // The reason may quote the file, and a file may hold anything.
      result.rejections.push_back(
          {.index = input.index,
           .reason = PrintableUtf8(std::string(canonical.status().message()))});
      continue;
    }
    COHORT_ASSIGN_OR_RETURN(canonical->summary.blob, context.store.Put(canonical->blob));
    canonical->summary.index = input.index;
    result.ingested.push_back(std::move(canonical->summary));
  }
  return result;
}

}  // namespace cohort
