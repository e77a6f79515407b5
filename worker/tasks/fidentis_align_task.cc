#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/registration/fidentis_mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/fidentis_meshes.h"
#include "worker/tasks/fidentis_tasks.h"

namespace cohort {
namespace {

/// Where the alignments of a task begin: where the round before put the meshes, or centred.
class Starts {
 public:
  static absl::StatusOr<Starts> Load(const Task& task, BlobStore& store) {
    Starts starts;
    COHORT_ASSIGN_OR_RETURN(starts.alignments_, LoadAlignments(store, task.alignments));
    COHORT_ASSIGN_OR_RETURN(std::vector<PlacedMesh> placed, LoadPlaced(store, task.partials));
    for (PlacedMesh& mesh : placed) {
      starts.placed_[mesh.mesh] = std::move(mesh.vertices);
    }
    return starts;
  }

  /// @return kDataLoss if the mesh is missing where others are placed, or has other vertices.
  [[nodiscard]] absl::StatusOr<FidentisStart> Of(const TaskMesh& mesh, BlobStore& store) const {
    COHORT_ASSIGN_OR_RETURN(const FileMesh file, LoadFileMesh(store, mesh));
    if (placed_.empty()) {
      return CenteredStart(file);
    }
    const auto found = placed_.find(mesh.index);
    if (found == placed_.end() || found->second.cols() != file.VertexCount()) {
      return absl::DataLossError("mesh " + mesh.name +
                                 ": where the last round put it is not in the task's inputs");
    }
    FidentisStart start;
    start.vertices = found->second;
    COHORT_ASSIGN_OR_RETURN(start.T_start_file, SimilarityOf(alignments_, mesh));
    return start;
  }

 private:
  std::map<int32_t, Alignment> alignments_;
  std::map<int32_t, Eigen::Matrix3Xf> placed_;
};

}  // namespace

absl::StatusOr<TaskResult> RunFidentisAlignTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const FidentisReference reference,
                          LoadFidentisReference(context.store, task.reference));
  COHORT_ASSIGN_OR_RETURN(const Starts starts, Starts::Load(task, context.store));
  const std::unique_ptr<const NearestVertex> target = NearestVertex::Build(reference.vertices);
  TaskResult result;
  result.counters.align.index_builds = task.counts_reference_index ? 1 : 0;
  std::vector<MeshAlignment> alignments;
  std::vector<PlacedMesh> placed;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const FidentisStart start, starts.Of(input, context.store));
    absl::StatusOr<FidentisAligned> aligned = AlignFidentis(start, *target, task.icp);
    if (!aligned.ok()) {
      result.rejections.push_back(
          {.index = input.index,
           .reason = input.name + ": not aligned: " + std::string(aligned.status().message())});
      continue;
    }
    result.counters.align.lookups += aligned->alignment.lookups;
    alignments.push_back({.mesh = input.index, .alignment = aligned->alignment});
    placed.push_back({.mesh = input.index, .vertices = std::move(aligned->moved)});
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeAlignmentBlob(alignments)));
  COHORT_ASSIGN_OR_RETURN(result.placed, context.store.Put(EncodePlacedBlob(placed)));
  return result;
}

absl::StatusOr<TaskResult> RunFidentisAverageTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const FidentisReference reference,
                          LoadFidentisReference(context.store, task.reference));
  COHORT_ASSIGN_OR_RETURN(const std::vector<PlacedMesh> placed,
                          LoadPlaced(context.store, task.partials));
  TaskResult result;
  FidentisMeanShape mean(reference.vertices);
  for (const PlacedMesh& mesh : placed) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    mean.Add(FidentisDisplacement(reference.vertices, *NearestVertex::Build(mesh.vertices)));
    result.counters.average += {.index_builds = 1, .lookups = reference.vertices.cols()};
  }
  TriangleMesh next;
  next.vertices = mean.Moved().cast<double>();
  next.faces = reference.faces;
  result.change =
      std::sqrt((next.vertices - reference.vertices.cast<double>()).colwise().squaredNorm().mean());
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeRawMeshBlob(next)));
  return result;
}

}  // namespace cohort
