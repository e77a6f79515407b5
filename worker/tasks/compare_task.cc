#include "worker/tasks/compare_task.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "common/pairs/pair_meter.h"
#include "worker/tasks/align_task.h"
#include "worker/tasks/tile_output.h"

namespace cohort {
namespace {

/// Meshes whose packed vertices stay in the cache of a core while all their pairs are measured.
constexpr size_t kInnerBlock = 8;

/// One block of the tile: its meshes in the common frame.
struct Block {
  std::vector<int32_t> meshes;
  std::vector<std::shared_ptr<const PackedMesh>> placed;
  std::vector<std::shared_ptr<const IcpMesh>> unplaced;        ///< Only for their boundaries.
  std::vector<std::shared_ptr<const PackedSurface>> surfaces;  ///< Only where they are needed.
};

absl::StatusOr<Block> LoadBlock(const std::vector<TaskMesh>& inputs,
                                const std::map<int32_t, Alignment>& alignments,
                                const Task& task,
                                const TaskContext& context,
                                WorkCounters& counters) {
  const Eigen::Vector3d frame_center(task.frame_center.data());
  Block block;
  for (const TaskMesh& input : inputs) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const Similarity T_frame_mesh, SimilarityOf(alignments, input));
    COHORT_ASSIGN_OR_RETURN(auto placed,
                            context.meshes.GetPlaced(input.blob, T_frame_mesh, frame_center));
    block.meshes.push_back(input.index);
    block.placed.push_back(std::move(placed));
    if (task.compare.boundary_pairs == BoundaryPairs::kReject) {
      COHORT_ASSIGN_OR_RETURN(auto unplaced, context.meshes.GetIcpMesh(input.blob));
      block.unplaced.push_back(std::move(unplaced));
    }
    if (task.compare.correspondence == Correspondence::kSurface) {
      COHORT_ASSIGN_OR_RETURN(
          auto surface, context.meshes.GetPlacedSurface(input.blob, T_frame_mesh, frame_center));
      block.surfaces.push_back(std::move(surface));
    }
    ++counters.index_builds;
  }
  return block;
}

/// All pairs, inner block by inner block.
absl::StatusOr<MeasuredBlock> MeasureBlock(const Block& sources,
                                           const Block& targets,
                                           const TaskContext& context,
                                           PairMeter& meter,
                                           Counters& counters) {
  const size_t rows = sources.placed.size();
  const size_t columns = targets.placed.size();
  MeasuredBlock measured(sources.meshes, targets.meshes);
  const auto measure = [&](size_t row, size_t column) -> absl::Status {
    const PairTarget target = {
        .vertices = *targets.placed[column],
        .unplaced = targets.unplaced.empty() ? nullptr : targets.unplaced[column].get(),
        .surface = targets.surfaces.empty() ? nullptr : targets.surfaces[column].get()};
    COHORT_ASSIGN_OR_RETURN(MeasuredPair pair, meter.Measure(*sources.placed[row], target));
    measured.Set(row * columns + column, std::move(pair));
    counters.compare.lookups += sources.placed[row]->VertexCount();
    ++counters.pairs;
    return absl::OkStatus();
  };
  for (size_t row_block = 0; row_block < rows; row_block += kInnerBlock) {
    for (size_t column_block = 0; column_block < columns; column_block += kInnerBlock) {
      COHORT_RETURN_IF_ERROR(context.CheckStop());
      for (size_t row = row_block; row < std::min(rows, row_block + kInnerBlock); ++row) {
        for (size_t column = column_block; column < std::min(columns, column_block + kInnerBlock);
             ++column) {
          COHORT_RETURN_IF_ERROR(measure(row, column));
        }
      }
    }
  }
  return measured;
}

}  // namespace

absl::StatusOr<TaskResult> RunCompareTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto alignments, LoadAlignments(context.store, task.alignments));
  TaskResult result;
  PairMeter meter(task.compare);
  TileOutput output(task.compare.retention);
  COHORT_ASSIGN_OR_RETURN(
      const Block rows, LoadBlock(task.meshes, alignments, task, context, result.counters.compare));
  if (task.targets == task.meshes) {
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock block,
                            MeasureBlock(rows, rows, context, meter, result.counters));
    output.Add(std::move(block));
  } else {
    COHORT_ASSIGN_OR_RETURN(const Block columns, LoadBlock(task.targets, alignments, task, context,
                                                           result.counters.compare));
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock there,
                            MeasureBlock(rows, columns, context, meter, result.counters));
    COHORT_ASSIGN_OR_RETURN(MeasuredBlock back,
                            MeasureBlock(columns, rows, context, meter, result.counters));
    output.Add(std::move(there));
    output.Add(std::move(back));
  }
  COHORT_RETURN_IF_ERROR(output.Write(context, result));
  return result;
}

absl::StatusOr<TaskResult> RunAlignAndCompareTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto poses, LoadAlignments(context.store, task.alignments));
  const TaskMesh& target_input = task.targets.at(0);
  const bool needs_surface = task.icp.correspondence == Correspondence::kSurface ||
                             task.compare.correspondence == Correspondence::kSurface;
  COHORT_ASSIGN_OR_RETURN(
      const auto target,
      context.meshes.GetIcpTarget(
          target_input.blob, needs_surface ? Correspondence::kSurface : Correspondence::kVertex));
  COHORT_ASSIGN_OR_RETURN(const Similarity T_base_target, SimilarityOf(poses, target_input));
  PairMeter meter(task.compare);
  TaskResult result;
  result.counters.align.index_builds = 1;
  std::vector<int32_t> sources;
  for (const TaskMesh& input : task.meshes) {
    sources.push_back(input.index);
  }
  MeasuredBlock block(sources, {target_input.index});
  std::vector<MeshAlignment> alignments;
  MeasuredPair failed;
  failed.metrics.fill(std::numeric_limits<double>::quiet_NaN());
  for (size_t place = 0; place < task.meshes.size(); ++place) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    const TaskMesh& input = task.meshes[place];
    COHORT_ASSIGN_OR_RETURN(const auto source, context.meshes.GetIcpMesh(input.blob));
    COHORT_ASSIGN_OR_RETURN(const Similarity T_base_source, SimilarityOf(poses, input));
    const absl::StatusOr<Alignment> aligned = AlignMesh(
        task, input, *target, T_base_target.Inverse() * T_base_source, context, meter.Search());
    ++result.counters.pairs;
    if (!aligned.ok()) {
      block.Set(place, failed);
      continue;
    }
    result.counters.align.lookups += aligned->lookups;
    alignments.push_back({.mesh = input.index, .alignment = *aligned});
    // A mesh lies on itself exactly; its fitted pose differs from the identity by rounding.
    const bool is_target = input.index == target_input.index;
    const Similarity T_target_source = is_target ? Similarity{} : aligned->T_target_source;
    COHORT_ASSIGN_OR_RETURN(MeasuredPair pair,
                            meter.MeasureMoved(*source, *target, T_target_source));
    block.Set(place, std::move(pair));
    result.counters.compare.lookups += source->Packed().VertexCount();
  }
  TileOutput output(task.compare.retention);
  output.Add(std::move(block));
  COHORT_RETURN_IF_ERROR(output.Write(context, result));
  COHORT_ASSIGN_OR_RETURN(result.second_output, context.store.Put(EncodeAlignmentBlob(alignments)));
  return result;
}

}  // namespace cohort
