#include <algorithm>

#include "common/base/status_macros.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kPoseSecondsPerMesh = 0.01;
constexpr double kSecondsPerLookup = 6e-8;  ///< To the surface.
constexpr int kExpectedIterations = 35;

/// Every mesh gives way to its symmetric copy. The ingested mesh stays what it is: it is known to
/// other jobs.
class SymmetrizeStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "symmetrize"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return static_cast<int64_t>(state.batches.size());
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const std::vector<int32_t>& meshes = state.batches[static_cast<size_t>(task)].meshes;
    return static_cast<double>(meshes.size()) * kPoseSecondsPerMesh +
           state.VerticesOf(meshes) * kExpectedIterations * kSecondsPerLookup;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made;
    made.kind = TaskKind::kSymmetrize;
    made.meshes = state.TaskMeshes(state.batches[static_cast<size_t>(task)].meshes);
    made.icp = state.spec.icp;
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      for (const SymmetricCopy& copy : result.copies) {
        state.meshes[static_cast<size_t>(copy.index)].copy = copy;
      }
    }
    state.RejectAllOf(results);
    COHORT_RETURN_IF_ERROR(state.CheckEnoughLeft());
    return state.ChooseBase();
  }
};

}  // namespace

std::unique_ptr<const Stage> MakeSymmetrizeStage() {
  return std::make_unique<SymmetrizeStage>();
}

}  // namespace cohort
