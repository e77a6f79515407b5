#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "common/jobs/blobs.h"
#include "common/jobs/preview_blobs.h"
#include "common/jobs/task.h"

namespace cohort {

/// What a task makes of the displacements from the vertices of its reference to aligned meshes.
class VariationOutput {
 public:
  /// @param task      moves_reference, wants_correspondences; at most its meshes are added.
  /// @param vertices  of the reference.
  VariationOutput(const Task& task, int64_t vertices);

  /// @param mesh          its index in the job.
  /// @param displacement  3 x vertices, reference units.
  /// @param counters      of the task; the mesh is added to `variation`.
  void Add(int32_t mesh, const Eigen::Matrix3Xd& displacement, Counters& counters);

  struct Blobs {
    std::string variation;
    std::string signatures;
    std::string correspondences;  ///< Empty if the task does not want them.
  };
  [[nodiscard]] Blobs Encode() &&;

 private:
  bool wants_correspondences_;
  bool moves_reference_;
  VariationPart part_;  ///< Without its sum of displacements.
  Eigen::Matrix3Xd sum_;
  CorrespondencePart signatures_;
  CorrespondencePart correspondences_;
};

}  // namespace cohort
