#include "server/planning/job_plan.h"

#include <numeric>
#include <set>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "server/planning/plan_state.h"
#include "server/planning/plan_steps.h"
#include "server/planning/staged_plan.h"

namespace cohort {
namespace {

absl::Status CheckMeshes(const std::vector<SetMesh>& meshes) {
  if (meshes.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("a comparison needs 2 meshes, the set has ", meshes.size()));
  }
  for (size_t i = 1; i < meshes.size(); ++i) {
    if (meshes[i - 1].name >= meshes[i].name) {
      return absl::InvalidArgumentError(absl::StrCat(
          "mesh ", meshes[i].name, " is twice there or out of order after ", meshes[i - 1].name));
    }
  }
  return absl::OkStatus();
}

/// The mesh that the job names as its base; the first one if it names none.
absl::StatusOr<int32_t> FindBase(const std::string& name, const std::vector<SetMesh>& meshes) {
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (name.empty() || meshes[i].name == name) {
      return static_cast<int32_t>(i);
    }
  }
  return absl::InvalidArgumentError(absl::StrCat("the base mesh ", name, " is not among the ",
                                                 meshes.size(), " meshes (", meshes.front().name,
                                                 " to ", meshes.back().name, ")"));
}

/// Takes over what a reference job has found.
absl::Status KeepFrame(const JobOutputs& kept, PlanState& state) {
  if (kept.frame.reference.empty() || kept.alignments.size() > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("nothing is kept of the reference job ", state.spec.reference_job));
  }
  std::set<int32_t> meshes;
  for (const ImportedPairs& pairs : kept.imported) {
    for (const int32_t mesh : pairs.mesh_of) {
      if (mesh >= static_cast<int32_t>(state.meshes.size())) {
        return absl::InvalidArgumentError(
            absl::StrCat("mesh ", mesh, " is kept, of ", state.meshes.size()));
      }
      if (mesh >= 0) {
        meshes.insert(mesh);
      }
    }
  }
  state.kept.assign(meshes.begin(), meshes.end());
  if (!kept.alignments.empty()) {
    state.kept_alignments = kept.alignments.front();
  }
  state.outputs.frame = kept.frame;
  state.outputs.imported = kept.imported;
  return absl::OkStatus();
}

absl::Status AddKnown(const std::vector<IngestedMesh>& known, std::vector<JobMesh>& meshes) {
  for (const IngestedMesh& mesh : known) {
    if (mesh.index < 0 || mesh.index >= static_cast<int32_t>(meshes.size())) {
      return absl::InvalidArgumentError(
          absl::StrCat("known mesh has index ", mesh.index, " of ", meshes.size()));
    }
    JobMesh& target = meshes[static_cast<size_t>(mesh.index)];
    if (target.ingested || mesh.blob.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "known mesh ", target.mesh.name, mesh.blob.empty() ? " has no blob" : " is there twice"));
    }
    target.ingested = mesh;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<JobPlan>> JobPlan::Create(const JobSpec& spec,
                                                         const std::vector<SetMesh>& meshes,
                                                         const std::vector<IngestedMesh>& known,
                                                         const JobOutputs& kept) {
  COHORT_RETURN_IF_ERROR(spec.Validate());
  COHORT_RETURN_IF_ERROR(CheckMeshes(meshes));
  PlanState state;
  state.spec = spec;
  COHORT_ASSIGN_OR_RETURN(state.base, FindBase(spec.base, meshes));
  for (const SetMesh& mesh : meshes) {
    state.meshes.push_back(
        {.mesh = mesh, .ingested = std::nullopt, .copy = std::nullopt, .rejection = {}});
  }
  COHORT_RETURN_IF_ERROR(AddKnown(known, state.meshes));
  if (state.HasKeptFrame()) {
    COHORT_RETURN_IF_ERROR(KeepFrame(kept, state));
  }
  state.active.resize(meshes.size());
  std::iota(state.active.begin(), state.active.end(), 0);
  state.GuessFileVertices();
  state.FormBatches();
  return StagedPlan::Start(std::move(state), MakeSteps(spec));
}

std::vector<Task> JobPlan::TakeReadyTasks() {
  std::vector<Task> tasks;
  for (const TaskRange& range : TakeReady()) {
    for (int64_t number = range.first; number < range.first + range.count; ++number) {
      tasks.push_back(MakeTask(number));
    }
  }
  return tasks;
}

}  // namespace cohort
