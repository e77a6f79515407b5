#include "worker/tasks/displacement_finder.h"

#include "common/base/status_macros.h"
#include "common/geometry/registration/mean_shape.h"

namespace cohort {

absl::StatusOr<DisplacementFinder> DisplacementFinder::Create(const Digest& reference,
                                                              Correspondence correspondence,
                                                              const TaskContext& context) {
  DisplacementFinder finder(correspondence, context);
  COHORT_ASSIGN_OR_RETURN(finder.reference_, context.meshes.Get(reference));
  COHORT_ASSIGN_OR_RETURN(finder.queries_, context.meshes.GetIcpMesh(reference));
  return finder;
}

absl::StatusOr<Eigen::Matrix3Xd> DisplacementFinder::Find(const Digest& mesh,
                                                          const Similarity& T_reference_mesh) {
  COHORT_ASSIGN_OR_RETURN(const auto target, meshes_.GetIcpTarget(mesh, correspondence_));
  if (correspondence_ == Correspondence::kSurface) {
    return DisplacementToSurface(reference_->vertices, *queries_, *target, T_reference_mesh,
                                 surface_search_);
  }
  COHORT_ASSIGN_OR_RETURN(const auto shape, meshes_.Get(mesh));
  return DisplacementToMesh(reference_->vertices, *queries_, shape->vertices, *target,
                            T_reference_mesh, search_);
}

}  // namespace cohort
