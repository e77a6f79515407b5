#pragma once

#include <memory>

#include <absl/status/statusor.h>

#include "common/geometry/registration/coarse_pose.h"
#include "common/geometry/registration/similarity.h"
#include "worker/tasks/task_context.h"

namespace cohort {

/// Coarse poses of meshes to one target: by the landmarks of the task, or by their shape if it has
/// none. Lives no longer than its task and context.
class PoseFinder {
 public:
  /// @param target  its blob is used for poses by shape, its name for landmarks.
  /// @return as MeshCache::GetPoseShape, GetLandmarks; kFailedPrecondition if the target has no
  /// landmarks.
  [[nodiscard]] static absl::StatusOr<PoseFinder> Create(const Task& task,
                                                         const TaskMesh& target,
                                                         const TaskContext& context);

  /// Landmarks: with the scale of the task's scale mode, but rigid if it has a scale limit, which
  /// counts from the start of ICP; the score is the RMS over all common landmarks.
  /// @return as FindCoarsePose or FitLandmarks; kInvalidArgument if the mesh has no landmarks; as
  ///         MeshCache::Get.
  [[nodiscard]] absl::StatusOr<CoarsePose> Find(const TaskMesh& mesh) const;

  /// Whether Find failed for what the mesh is, so that no other try can succeed and the mesh must
  /// leave the job.
  [[nodiscard]] static bool IsTheMeshsFault(const absl::Status& status);

 private:
  explicit PoseFinder(const TaskContext& context) : context_(&context) {}

  const TaskContext* context_;
  std::shared_ptr<const PoseShape> target_shape_;   ///< By shape.
  std::shared_ptr<const LandmarkTable> landmarks_;  ///< By landmarks; else null.
  const LandmarkSet* target_landmarks_ = nullptr;   ///< In `landmarks_`.
  ScaleMode scale_mode_ = ScaleMode::kOff;
};

}  // namespace cohort
