#include <array>
#include <iterator>
#include <vector>

#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerLookup = 7e-8;
constexpr double kSummarizeSecondsPerDistance = 1e-7;

/// Distances of each reference vertex to the aligned meshes of one batch.
class VariationStage final : public Stage {
 public:
  explicit VariationStage(const VariationParts& parts) : parts_(parts) {}

  [[nodiscard]] std::string Name() const override { return "variation"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return state.HasKeptFrame() ? state.BatchesOfActive(state.ActiveCount()).Count()
                                : std::ssize(state.batches);
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    return state.VerticesOf(state.base) * static_cast<double>(MeshesOf(state, task).size()) *
           kSecondsPerLookup;
  }
  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    return {MeshesOf(state, task).front(), TaskTraits::kNothing};
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const std::vector<int32_t> meshes = MeshesOf(state, task);
    Task made;
    made.kind = TaskKind::kVariation;
    made.meshes = state.TaskMeshes(meshes);
    made.reference = state.reference;
    made.icp.correspondence = state.spec.icp.correspondence;
    made.wants_correspondences = parts_.correspondences;
    made.moves_reference = parts_.last_shape == LastShape::kReferencePlusDisplacement;
    made.alignments = state.AlignmentsOf(meshes);
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (size_t i = 0; i < results.size(); ++i) {
      state.variations.push_back(results[i].output);
      if (!results[i].fields.empty()) {
        state.outputs.signatures.push_back(results[i].fields);
      }
      if (parts_.correspondences) {
        state.batches[i].displacement = results[i].second_output;
      }
    }
    return absl::OkStatus();
  }

 private:
  /// A batch. Where some are kept, the meshes in their order, so that sums over a set that grew
  /// are those over one that was there from the beginning.
  static std::vector<int32_t> MeshesOf(const PlanState& state, int64_t task) {
    if (!state.HasKeptFrame()) {
      return state.batches[static_cast<size_t>(task)].meshes;
    }
    const MeshRange batch = state.BatchesOfActive(state.ActiveCount()).At(task);
    return {state.active.begin() + batch.begin, state.active.begin() + batch.end};
  }

  VariationParts parts_;
};

/// Per-vertex metrics over all meshes, and the mean shape.
class SummarizeStage final : public Stage {
 public:
  explicit SummarizeStage(LastShape last_shape) : last_shape_(last_shape) {}

  [[nodiscard]] std::string Name() const override { return "summarize"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& /*state*/) const override { return 1; }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    return state.VerticesOf(state.base) * static_cast<double>(state.ActiveCount()) *
           kSummarizeSecondsPerDistance;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t /*task*/) const override {
    Task made;
    made.kind = TaskKind::kSummarize;
    made.reference = state.reference;
    made.partials = state.variations;
    made.moves_reference = last_shape_ == LastShape::kReferencePlusDisplacement;
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    state.CollectAlignments();  // A set that only shrank has compared nothing before.
    state.outputs.summary = results.front().output;
    state.outputs.mean_shape = results.front().second_output;
    return absl::OkStatus();
  }

 private:
  LastShape last_shape_;
};

}  // namespace

std::unique_ptr<const Stage> MakeVariationStage(const VariationParts& parts) {
  return std::make_unique<VariationStage>(parts);
}

std::unique_ptr<const Stage> MakeSummarizeStage(LastShape last_shape) {
  return std::make_unique<SummarizeStage>(last_shape);
}

}  // namespace cohort
