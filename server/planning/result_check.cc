#include "server/planning/result_check.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"

namespace cohort {
namespace {

absl::Status Misfit(const Task& task, const std::string& problem) {
  return absl::InvalidArgumentError(
      absl::StrCat("result of task ", task.number, " (", task.stage, "): ", problem));
}

bool HasMesh(const Task& task, int32_t index) {
  return std::any_of(task.meshes.begin(), task.meshes.end(),
                     [index](const TaskMesh& mesh) { return mesh.index == index; });
}

/// Every mesh of the task exactly once. A task that was planned before a restart may answer for
/// more meshes than it has now; those are known already.
absl::Status CheckIngested(const PlanState& state, const Task& task, const TaskResult& result) {
  std::set<int32_t> answered;
  const auto answer = [&](int32_t index) -> absl::Status {
    const bool in_job = index >= 0 && index < static_cast<int32_t>(state.meshes.size());
    const bool expected = HasMesh(task, index) ||
                          (in_job && state.meshes[static_cast<size_t>(index)].ingested.has_value());
    if (!expected || !answered.insert(index).second) {
      return Misfit(task, absl::StrCat("mesh ", index, expected ? " twice" : " is not of it"));
    }
    return absl::OkStatus();
  };
  for (const IngestedMesh& mesh : result.ingested) {
    COHORT_RETURN_IF_ERROR(answer(mesh.index));
    if (mesh.blob.empty()) {
      return Misfit(task, absl::StrCat("mesh ", mesh.index, " without a blob"));
    }
  }
  for (const MeshRejection& rejection : result.rejections) {
    COHORT_RETURN_IF_ERROR(answer(rejection.index));
    if (!HasMesh(task, rejection.index)) {
      return Misfit(task, absl::StrCat("mesh ", rejection.index, " was accepted before"));
    }
  }
  for (const TaskMesh& mesh : task.meshes) {
    if (!answered.contains(mesh.index)) {
      return Misfit(task, absl::StrCat(mesh.name, " is neither ingested nor rejected"));
    }
  }
  return absl::OkStatus();
}

/// Every mesh of the task exactly once: a copy or a rejection.
absl::Status CheckSymmetrized(const Task& task, const TaskResult& result) {
  std::set<int32_t> answered;
  const auto answer = [&](int32_t index) {
    return HasMesh(task, index) && answered.insert(index).second
               ? absl::OkStatus()
               : Misfit(task, absl::StrCat("mesh ", index, " is not of it, or there twice"));
  };
  for (const SymmetricCopy& copy : result.copies) {
    COHORT_RETURN_IF_ERROR(answer(copy.index));
    if (copy.blob.empty()) {
      return Misfit(task, absl::StrCat("mesh ", copy.index, " without a blob"));
    }
  }
  for (const MeshRejection& rejection : result.rejections) {
    COHORT_RETURN_IF_ERROR(answer(rejection.index));
  }
  return answered.size() == task.meshes.size()
             ? absl::OkStatus()
             : Misfit(task, absl::StrCat(task.meshes.size() - answered.size(),
                                         " meshes are neither copied nor rejected"));
}

/// A blob, or the alignments of every mesh of the task that it does not reject. (Earlier builds
/// wrote a blob in the rounds of the mean shape, too.)
absl::Status CheckOutput(const Task& task,
                         const TaskResult& result,
                         const std::set<int32_t>& rejected) {
  if (!task.wants_displacement || result.alignments.empty()) {
    return result.output.empty() ? Misfit(task, "no output") : absl::OkStatus();
  }
  const absl::StatusOr<std::vector<MeshAlignment>> alignments =
      DecodeAlignmentBlob(result.alignments);
  if (!alignments.ok()) {
    return Misfit(task, std::string(alignments.status().message()));
  }
  std::set<int32_t> aligned;
  for (const MeshAlignment& one : *alignments) {
    aligned.insert(one.mesh);
  }
  for (const TaskMesh& mesh : task.meshes) {
    if (!aligned.contains(mesh.index) && !rejected.contains(mesh.index)) {
      return Misfit(task, mesh.name + " is neither aligned nor rejected");
    }
  }
  return absl::OkStatus();
}

bool MayReject(TaskKind kind) {
  return kind == TaskKind::kPose || kind == TaskKind::kAlign;
}

bool HasSecondOutput(const Task& task) {
  return task.wants_displacement || task.wants_correspondences ||
         task.kind == TaskKind::kAlignAndCompare || task.kind == TaskKind::kSummarize;
}

}  // namespace

absl::Status CheckResult(const PlanState& state, const Task& task, const TaskResult& result) {
  if (task.kind == TaskKind::kIngest) {
    return CheckIngested(state, task, result);
  }
  if (task.kind == TaskKind::kSymmetrize) {
    return CheckSymmetrized(task, result);
  }
  std::set<int32_t> rejected;
  for (const MeshRejection& rejection : result.rejections) {
    if (!MayReject(task.kind) || !HasMesh(task, rejection.index)) {
      return Misfit(task, absl::StrCat("mesh ", rejection.index, " is not its to reject"));
    }
    rejected.insert(rejection.index);
  }
  if (MayReject(task.kind) && rejected.size() == task.meshes.size()) {
    return absl::OkStatus();  // Nothing was left to write about.
  }
  COHORT_RETURN_IF_ERROR(CheckOutput(task, result, rejected));
  if (task.kind == TaskKind::kChooseBase && !HasMesh(task, result.base)) {
    return Misfit(task, absl::StrCat("mesh ", result.base, " is not its to choose"));
  }
  if (HasSecondOutput(task) && result.second_output.empty()) {
    return Misfit(task, "no second output");
  }
  if (task.wants_pose && result.poses.empty()) {
    return Misfit(task, "no poses");
  }
  if (task.wants_variation && result.variation.empty()) {
    return Misfit(task, "no variation");
  }
  if (task.wants_placed && result.placed.empty()) {
    return Misfit(task, "no placed meshes");
  }
  return absl::OkStatus();
}

}  // namespace cohort
