#include "worker/tasks/compare_task.h"

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/nearest/nearest_vertex.h"
#include "common/jobs/blobs.h"

namespace cohort {
namespace {

/// Nearest-vertex distances of `points` to the vertices behind `index`, as metrics.
MetricValues Measure(const Eigen::Matrix3Xf& points, const NearestVertex& index) {
  std::vector<int32_t> nearest(static_cast<size_t>(points.cols()));
  std::vector<float> squared_distances(nearest.size());
  index.Find(points, nearest, squared_distances);
  return ComputeMetrics(squared_distances);
}

/// One block of the tile: its meshes in the common frame, behind indexes.
struct Block {
  std::vector<int32_t> meshes;
  std::vector<std::unique_ptr<const NearestVertex>> indexes;
};

absl::StatusOr<Block> LoadBlock(const std::vector<TaskMesh>& inputs,
                                const std::map<int32_t, Alignment>& alignments,
                                const Eigen::Vector3d& frame_center,
                                const TaskContext& context,
                                WorkCounters& counters) {
  Block block;
  for (const TaskMesh& input : inputs) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const auto mesh, context.meshes.Get(input.blob));
    COHORT_ASSIGN_OR_RETURN(const Similarity T_frame_mesh, SimilarityOf(alignments, input));
    const Eigen::Matrix3Xf vertices =
        (T_frame_mesh.Apply(mesh->vertices).colwise() - frame_center).cast<float>();
    block.meshes.push_back(input.index);
    block.indexes.push_back(NearestVertex::Build(vertices));
    ++counters.index_builds;
  }
  return block;
}

absl::StatusOr<MetricBlock> MeasureBlock(const Block& sources,
                                         const Block& targets,
                                         const TaskContext& context,
                                         Counters& counters) {
  MetricBlock measured{.sources = sources.meshes, .targets = targets.meshes, .values = {}};
  for (const auto& source : sources.indexes) {
    for (const auto& target : targets.indexes) {
      COHORT_RETURN_IF_ERROR(context.CheckStop());
      measured.values.push_back(Measure(source->Vertices(), *target));
      counters.compare.lookups += source->Vertices().cols();
      ++counters.pairs;
    }
  }
  return measured;
}

}  // namespace

absl::StatusOr<TaskResult> RunCompareTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto alignments, LoadAlignments(context.store, task.alignments));
  const Eigen::Vector3d frame_center(task.frame_center.data());
  TaskResult result;
  COHORT_ASSIGN_OR_RETURN(const Block rows, LoadBlock(task.meshes, alignments, frame_center,
                                                      context, result.counters.compare));
  std::vector<MetricBlock> blocks;
  if (task.targets == task.meshes) {
    COHORT_ASSIGN_OR_RETURN(MetricBlock block, MeasureBlock(rows, rows, context, result.counters));
    blocks.push_back(std::move(block));
  } else {
    COHORT_ASSIGN_OR_RETURN(const Block columns, LoadBlock(task.targets, alignments, frame_center,
                                                           context, result.counters.compare));
    COHORT_ASSIGN_OR_RETURN(MetricBlock there,
                            MeasureBlock(rows, columns, context, result.counters));
    COHORT_ASSIGN_OR_RETURN(MetricBlock back,
                            MeasureBlock(columns, rows, context, result.counters));
    blocks.push_back(std::move(there));
    blocks.push_back(std::move(back));
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeTileBlob(blocks)));
  return result;
}

absl::StatusOr<TaskResult> RunAlignAndCompareTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto poses, LoadAlignments(context.store, task.alignments));
  const TaskMesh& target_input = task.targets.at(0);
  COHORT_ASSIGN_OR_RETURN(const auto target_mesh, context.meshes.Get(target_input.blob));
  COHORT_ASSIGN_OR_RETURN(const Similarity T_base_target, SimilarityOf(poses, target_input));
  const IcpTarget target(target_mesh->vertices);
  TaskResult result;
  result.counters.align.index_builds = 1;
  MetricBlock block;
  block.targets = {target_input.index};
  std::vector<MeshAlignment> alignments;
  MetricValues failed;
  failed.fill(std::numeric_limits<double>::quiet_NaN());
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const auto mesh, context.meshes.Get(input.blob));
    COHORT_ASSIGN_OR_RETURN(const Similarity T_base_source, SimilarityOf(poses, input));
    const absl::StatusOr<Alignment> aligned =
        AlignByIcp(mesh->vertices, target, T_base_target.Inverse() * T_base_source, task.icp);
    block.sources.push_back(input.index);
    ++result.counters.pairs;
    if (!aligned.ok()) {
      block.values.push_back(failed);
      continue;
    }
    result.counters.align.lookups += aligned->lookups;
    alignments.push_back({.mesh = input.index, .alignment = *aligned});
    // A mesh lies on itself exactly; its fitted pose differs from the identity by rounding.
    const bool is_target = input.index == target_input.index;
    const Similarity T_target_source = is_target ? Similarity{} : aligned->T_target_source;
    const Eigen::Matrix3Xf points =
        (T_target_source.Apply(mesh->vertices).colwise() - target.Center()).cast<float>();
    block.values.push_back(Measure(points, target.Index()));
    result.counters.compare.lookups += points.cols();
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeTileBlob({block})));
  COHORT_ASSIGN_OR_RETURN(result.second_output, context.store.Put(EncodeAlignmentBlob(alignments)));
  return result;
}

}  // namespace cohort
