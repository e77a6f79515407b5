#include "worker/tasks/pose_finder.h"

#include "common/base/status_macros.h"
#include "common/geometry/registration/landmark_fit.h"

namespace cohort {

absl::StatusOr<PoseFinder> PoseFinder::Create(const Task& task,
                                              const TaskMesh& target,
                                              const TaskContext& context) {
  PoseFinder finder(context);
  if (task.landmarks.empty()) {
    COHORT_ASSIGN_OR_RETURN(finder.target_shape_, context.meshes.GetPoseShape(target.blob));
    return finder;
  }
  COHORT_ASSIGN_OR_RETURN(finder.landmarks_, context.meshes.GetLandmarks(task.landmarks));
  const auto found = finder.landmarks_->find(target.name);
  if (found == finder.landmarks_->end()) {
    return absl::FailedPreconditionError("the base mesh " + target.name + " has no landmarks");
  }
  finder.target_landmarks_ = &found->second;
  finder.scale_mode_ = task.icp.scale_limit > 0 ? ScaleMode::kOff : task.icp.scale_mode;
  return finder;
}

absl::StatusOr<CoarsePose> PoseFinder::Find(const TaskMesh& mesh) const {
  if (landmarks_ == nullptr) {
    COHORT_ASSIGN_OR_RETURN(const auto source, context_->meshes.Get(mesh.blob));
    COHORT_ASSIGN_OR_RETURN(const PoseShape source_shape, PoseShape::Create(*source));
    return FindCoarsePose(source_shape, *target_shape_);
  }
  const auto found = landmarks_->find(mesh.name);
  if (found == landmarks_->end()) {
    return absl::InvalidArgumentError("it has no landmarks");
  }
  COHORT_ASSIGN_OR_RETURN(const LandmarkFit fit,
                          FitLandmarks(found->second, *target_landmarks_, scale_mode_));
  return CoarsePose{.T_target_source = fit.T_target_source, .score = fit.rms, .lookups = 0};
}

bool PoseFinder::IsTheMeshsFault(const absl::Status& status) {
  return status.code() == absl::StatusCode::kInvalidArgument ||
         status.code() == absl::StatusCode::kFailedPrecondition;
}

}  // namespace cohort
