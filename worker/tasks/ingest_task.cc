#include "worker/tasks/ingest_task.h"

#include <string>
#include <utility>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/bounds.h"
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

}  // namespace

absl::StatusOr<TaskResult> RunIngestTask(const Task& task, const TaskContext& context) {
  TaskResult result;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(input.blob));
    absl::StatusOr<CanonicalMesh> canonical = MakeCanonical(bytes, input.name, task.position_bits);
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
