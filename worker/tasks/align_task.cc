#include "worker/tasks/align_task.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/registration/mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/displacement_finder.h"
#include "worker/tasks/pose_finder.h"
#include "worker/tasks/variation_output.h"

namespace cohort {
namespace {

using Starts = std::map<int32_t, Alignment>;  ///< By mesh; empty: identities.

/// What an alignment writes; empty: not wanted.
struct AlignBlobs {
  std::string alignments;
  std::string poses;
  std::string displacement;
  VariationOutput::Blobs variation;
};

/// Coarse poses to the reference of the task. A mesh that none is found for is rejected.
absl::StatusOr<std::vector<MeshAlignment>> FindPoses(const Task& task,
                                                     const TaskContext& context,
                                                     TaskResult& result) {
  const std::string base_name = task.targets.empty() ? "" : task.targets.front().name;
  COHORT_ASSIGN_OR_RETURN(
      const PoseFinder poses_to_base,
      PoseFinder::Create(task, {.index = -1, .name = base_name, .blob = task.reference}, context));
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
  return poses;
}

/// Where the alignments begin: poses that are found now, or what is known.
absl::StatusOr<Starts> FindStarts(const Task& task,
                                  const TaskContext& context,
                                  AlignBlobs& blobs,
                                  TaskResult& result) {
  if (!task.wants_pose) {
    return task.starts.empty() ? LoadAlignments(context.store, task.alignments)
                               : AlignmentsIn(task.starts);
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> poses, FindPoses(task, context, result));
  blobs.poses = EncodeAlignmentBlob(poses);
  Starts starts;
  for (const MeshAlignment& pose : poses) {
    starts[pose.mesh] = pose.alignment;
  }
  return starts;
}

}  // namespace

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
  TaskResult result;
  COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> poses, FindPoses(task, context, result));
  const std::string blob = EncodeAlignmentBlob(poses);
  const std::array<TaskBlob, 1> written = {{{blob, result.output}}};
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

absl::StatusOr<TaskResult> RunAlignTask(const Task& task, const TaskContext& context) {
  TaskResult result;
  AlignBlobs blobs;
  COHORT_ASSIGN_OR_RETURN(const Starts starts, FindStarts(task, context, blobs, result));
  COHORT_ASSIGN_OR_RETURN(
      DisplacementFinder displacements,
      DisplacementFinder::Create(task.reference, task.icp.correspondence, context));
  COHORT_ASSIGN_OR_RETURN(const auto target,
                          context.meshes.GetIcpTarget(task.reference, task.icp.correspondence));
  PacketSearch search;
  result.counters.align.index_builds = task.counts_reference_index ? 1 : 0;
  std::vector<MeshAlignment> alignments;
  int64_t displaced = 0;
  Eigen::Matrix3Xd displacement =
      Eigen::Matrix3Xd::Zero(3, task.wants_displacement ? displacements.VertexCount() : 0);
  std::optional<VariationOutput> variation;
  if (task.wants_variation) {
    variation.emplace(task, displacements.VertexCount());
  }
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    if (task.wants_pose && !starts.contains(input.index)) {
      continue;  // Rejected: it has no pose.
    }
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
    if (!task.wants_displacement && !task.wants_variation) {
      continue;
    }
    COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3Xd found,
                            displacements.Find(input.blob, aligned->T_target_source));
    if (task.wants_displacement) {
      displacement += found;
      ++displaced;
      result.counters.average += {.index_builds = 1, .lookups = displacements.VertexCount()};
    }
    if (variation) {
      variation->Add(input.index, found, result.counters);
      COHORT_RETURN_IF_ERROR(context.meshes.SharePlaced(input.blob, aligned->T_target_source,
                                                        Eigen::Vector3d(task.frame_center.data())));
    }
  }
  if (task.wants_displacement) {
    result.alignments = EncodeAlignmentBlob(alignments);
    blobs.displacement =
        EncodeDisplacementBlob({.mesh_count = displaced, .sum = displacement.cast<float>()});
  } else {
    blobs.alignments = EncodeAlignmentBlob(alignments);
  }
  if (variation) {
    blobs.variation = std::move(*variation).Encode();
  }
  const std::array<TaskBlob, 6> written = {{{blobs.alignments, result.output},
                                            {blobs.poses, result.poses},
                                            {blobs.displacement, result.second_output},
                                            {blobs.variation.correspondences, result.second_output},
                                            {blobs.variation.variation, result.variation},
                                            {blobs.variation.signatures, result.fields}}};
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

absl::StatusOr<TaskResult> RunAverageTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto reference, context.meshes.Get(task.reference));
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, reference->VertexCount());
  int64_t mesh_count = 0;
  for (const Digest& blob : task.partials) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(const DisplacementSum part, DecodeDisplacementBlob(bytes));
    if (part.sum.cols() != reference->VertexCount()) {
      return absl::DataLossError("displacement blob " + blob.Hex() + " does not fit the reference");
    }
    mesh_count += part.mesh_count;
    sum += part.sum.cast<double>();
  }
  if (mesh_count == 0) {
    return absl::FailedPreconditionError("no mesh could be aligned to the reference");
  }
  TriangleMesh next;
  next.vertices = MoveByMeanDisplacement(reference->vertices, std::span(&sum, 1), mesh_count);
  next.faces = reference->faces;
  TaskResult result;
  result.change = std::sqrt((next.vertices - reference->vertices).squaredNorm() /
                            static_cast<double>(next.VertexCount()));
  const std::string blob = EncodeRawMeshBlob(next);
  const std::array<TaskBlob, 1> written = {{{blob, result.output}}};
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

}  // namespace cohort
