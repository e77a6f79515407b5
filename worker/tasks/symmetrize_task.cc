#include "worker/tasks/symmetrize_task.h"

#include <string>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/registration/mirror.h"
#include "common/store/mesh_blob.h"

namespace cohort {

absl::StatusOr<TaskResult> RunSymmetrizeTask(const Task& task, const TaskContext& context) {
  PacketSearch search;
  TaskResult result;
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const auto mesh, context.meshes.Get(input.blob));
    const absl::StatusOr<SymmetricMesh> symmetric = MakeSymmetric(*mesh, task.icp, search);
    if (!symmetric.ok()) {
      result.rejections.push_back({.index = input.index,
                                   .reason = input.name + ": no symmetric copy: " +
                                             std::string(symmetric.status().message())});
      continue;
    }
    SymmetricCopy copy{.index = input.index, .blob = {}, .asymmetry = symmetric->asymmetry};
    COHORT_ASSIGN_OR_RETURN(copy.blob, context.store.Put(EncodeRawMeshBlob(symmetric->mesh)));
    result.copies.push_back(std::move(copy));
  }
  return result;
}

}  // namespace cohort
