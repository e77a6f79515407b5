#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/jobs/blobs.h"
#include "worker/tasks/fidentis_meshes.h"
#include "worker/tasks/fidentis_tasks.h"
#include "worker/tasks/tile_output.h"

namespace cohort {
namespace {

/// One block of the tile: its meshes where they were aligned.
struct PlacedBlock {
  std::vector<int32_t> meshes;
  std::vector<Eigen::Matrix3Xf> vertices;
  std::vector<Eigen::Matrix3Xf> normals;
  std::vector<std::unique_ptr<const NearestVertex>> indexes;
};

using PlacedByMesh = std::map<int32_t, Eigen::Matrix3Xf>;

absl::StatusOr<PlacedBlock> LoadBlock(const std::vector<TaskMesh>& inputs,
                                      const PlacedByMesh& placed,
                                      const TaskContext& context,
                                      WorkCounters& counters) {
  PlacedBlock block;
  for (const TaskMesh& input : inputs) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const FileMesh file, LoadFileMesh(context.store, input));
    const auto found = placed.find(input.index);
    if (found == placed.end() || found->second.cols() != file.VertexCount()) {
      return absl::DataLossError("mesh " + input.name +
                                 ": where it was aligned is not in the task's inputs");
    }
    block.meshes.push_back(input.index);
    block.vertices.push_back(found->second);
    block.normals.push_back(FidentisNormalsOf(file, found->second));
    block.indexes.push_back(NearestVertex::Build(found->second));
    ++counters.index_builds;
  }
  return block;
}

absl::StatusOr<MeasuredBlock> MeasureBlock(const PlacedBlock& sources,
                                           const PlacedBlock& targets,
                                           const Task& task,
                                           const TaskContext& context,
                                           Counters& counters) {
  MeasuredBlock measured(sources.meshes, targets.meshes);
  const size_t columns = targets.meshes.size();
  for (size_t row = 0; row < sources.meshes.size(); ++row) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    for (size_t column = 0; column < columns; ++column) {
      const std::vector<float> distances = FidentisSignedDistances(
          sources.vertices[row], sources.normals[row], *targets.indexes[column]);
      measured.Set(row * columns + column, MeasureFidentis(distances, task.compare));
      counters.compare.lookups += std::ssize(distances);
      ++counters.pairs;
    }
  }
  return measured;
}

}  // namespace

absl::StatusOr<TaskResult> RunFidentisCompareTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(std::vector<PlacedMesh> loaded, LoadPlaced(context.store, task.partials));
  PlacedByMesh placed;
  for (PlacedMesh& mesh : loaded) {
    placed[mesh.mesh] = std::move(mesh.vertices);
  }
  TaskResult result;
  TileOutput output(task.compare.retention);
  COHORT_ASSIGN_OR_RETURN(const PlacedBlock rows,
                          LoadBlock(task.meshes, placed, context, result.counters.compare));
  if (task.targets == task.meshes) {
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock block,
                            MeasureBlock(rows, rows, task, context, result.counters));
    output.Add(std::move(block));
  } else {
    COHORT_ASSIGN_OR_RETURN(const PlacedBlock columns,
                            LoadBlock(task.targets, placed, context, result.counters.compare));
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock there,
                            MeasureBlock(rows, columns, task, context, result.counters));
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock back,
                            MeasureBlock(columns, rows, task, context, result.counters));
    output.Add(std::move(there));
    output.Add(std::move(back));
  }
  COHORT_RETURN_IF_ERROR(output.Write(context, result));
  return result;
}

absl::StatusOr<TaskResult> RunFidentisAlignAndCompareTask(const Task& task,
                                                          const TaskContext& context) {
  const TaskMesh& target_input = task.targets.at(0);
  COHORT_ASSIGN_OR_RETURN(const FidentisReference reference,
                          LoadFidentisReference(context.store, target_input.blob));
  const std::unique_ptr<const NearestVertex> target = NearestVertex::Build(reference.vertices);
  TaskResult result;
  result.counters.align.index_builds = 1;
  std::vector<int32_t> sources;
  for (const TaskMesh& input : task.meshes) {
    sources.push_back(input.index);
  }
  MeasuredBlock block(sources, {target_input.index});
  MeasuredPair failed;
  failed.metrics.fill(std::numeric_limits<double>::quiet_NaN());
  std::vector<MeshAlignment> alignments;
  std::vector<PlacedMesh> placed;
  for (size_t place = 0; place < task.meshes.size(); ++place) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    const TaskMesh& input = task.meshes[place];
    COHORT_ASSIGN_OR_RETURN(const FileMesh file, LoadFileMesh(context.store, input));
    absl::StatusOr<FidentisAligned> aligned = AlignFidentis(CenteredStart(file), *target, task.icp);
    ++result.counters.pairs;
    if (!aligned.ok()) {
      block.Set(place, failed);
      continue;
    }
    const std::vector<float> distances =
        FidentisSignedDistances(aligned->moved, FidentisNormalsOf(file, aligned->moved), *target);
    block.Set(place, MeasureFidentis(distances, task.compare));
    result.counters.align.lookups += aligned->alignment.lookups;
    result.counters.compare.lookups += file.VertexCount();
    alignments.push_back({.mesh = input.index, .alignment = aligned->alignment});
    if (task.wants_placed) {
      placed.push_back({.mesh = input.index, .vertices = std::move(aligned->moved)});
    }
  }
  TileOutput output(task.compare.retention);
  output.Add(std::move(block));
  COHORT_RETURN_IF_ERROR(output.Write(context, result));
  COHORT_ASSIGN_OR_RETURN(result.second_output, context.store.Put(EncodeAlignmentBlob(alignments)));
  if (task.wants_placed) {
    COHORT_ASSIGN_OR_RETURN(result.placed, context.store.Put(EncodePlacedBlob(placed)));
  }
  return result;
}

}  // namespace cohort
