#include "worker/tasks/align_task.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/registration/mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/displacement_finder.h"
#include "worker/tasks/pose_finder.h"

namespace cohort {

absl::StatusOr<Alignment> AlignMesh(const Task& task,
                                    const TaskMesh& source,
                                    const IcpMesh& target,
                                    const Similarity& T_target_source,
                                    const TaskContext& context,
                                    PacketSearch& search) {
  COHORT_ASSIGN_OR_RETURN(const auto mesh,
                          context.meshes.GetSampled(source.blob, task.undersampling));
  return AlignByIcp(*mesh, target, T_target_source, task.icp, search);
}

absl::StatusOr<TaskResult> RunPoseTask(const Task& task, const TaskContext& context) {
  const std::string base_name = task.targets.empty() ? "" : task.targets.front().name;
  COHORT_ASSIGN_OR_RETURN(
      const PoseFinder poses_to_base,
      PoseFinder::Create(task, {.index = -1, .name = base_name, .blob = task.reference}, context));
  TaskResult result;
  result.counters.pose.index_builds = task.counts_reference_index ? 1 : 0;
  std::vector<MeshAlignment> poses;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    const absl::StatusOr<CoarsePose> pose = poses_to_base.Find(input);
    if (!pose.ok()) {
      if (!PoseFinder::IsTheMeshsFault(pose.status())) {
        return pose.status();
      }
      result.rejections.push_back(
          {.index = input.index,
           .reason = input.name + ": no coarse pose: " + std::string(pose.status().message())});
      continue;
    }
    result.counters.pose.lookups += pose->lookups;
    MeshAlignment placed{.mesh = input.index, .alignment = {}};
    placed.alignment.T_target_source = pose->T_target_source;
    placed.alignment.rms_residual = pose->score;
    placed.alignment.lookups = pose->lookups;
    poses.push_back(placed);
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeAlignmentBlob(poses)));
  return result;
}

absl::StatusOr<TaskResult> RunAlignTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(
      DisplacementFinder displacements,
      DisplacementFinder::Create(task.reference, task.icp.correspondence, context));
  COHORT_ASSIGN_OR_RETURN(const auto starts, LoadAlignments(context.store, task.alignments));
  COHORT_ASSIGN_OR_RETURN(const auto target,
                          context.meshes.GetIcpTarget(task.reference, task.icp.correspondence));
  PacketSearch search;
  TaskResult result;
  result.counters.align.index_builds = task.counts_reference_index ? 1 : 0;
  std::vector<MeshAlignment> alignments;
  DisplacementSum displacement;
  displacement.sum = Eigen::Matrix3Xd::Zero(3, displacements.VertexCount());
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const Similarity start, SimilarityOf(starts, input));
    const absl::StatusOr<Alignment> aligned =
        AlignMesh(task, input, *target, start, context, search);
    if (!aligned.ok()) {
      result.rejections.push_back(
          {.index = input.index,
           .reason = input.name + ": not aligned: " + std::string(aligned.status().message())});
      continue;
    }
    result.counters.align.lookups += aligned->lookups;
    alignments.push_back({.mesh = input.index, .alignment = *aligned});
    if (task.wants_displacement) {
      COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3Xd found,
                              displacements.Find(input.blob, aligned->T_target_source));
      displacement.sum += found;
      ++displacement.mesh_count;
      result.counters.average += {.index_builds = 1, .lookups = displacements.VertexCount()};
    }
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeAlignmentBlob(alignments)));
  if (task.wants_displacement) {
    COHORT_ASSIGN_OR_RETURN(result.second_output,
                            context.store.Put(EncodeDisplacementBlob(displacement)));
  }
  return result;
}

absl::StatusOr<TaskResult> RunAverageTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto reference, context.meshes.Get(task.reference));
  std::vector<Eigen::Matrix3Xd> sums;
  int64_t mesh_count = 0;
  for (const Digest& blob : task.partials) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(DisplacementSum part, DecodeDisplacementBlob(bytes));
    if (part.sum.cols() != reference->VertexCount()) {
      return absl::DataLossError("displacement blob " + blob.Hex() + " does not fit the reference");
    }
    mesh_count += part.mesh_count;
    sums.push_back(std::move(part.sum));
  }
  if (mesh_count == 0) {
    return absl::FailedPreconditionError("no mesh could be aligned to the reference");
  }
  TriangleMesh next;
  next.vertices = MoveByMeanDisplacement(reference->vertices, sums, mesh_count);
  next.faces = reference->faces;
  TaskResult result;
  result.change = std::sqrt((next.vertices - reference->vertices).squaredNorm() /
                            static_cast<double>(next.VertexCount()));
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeRawMeshBlob(next)));
  return result;
}

}  // namespace cohort
