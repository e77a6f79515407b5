// Arithmetic::kFidentis: alignments go on from moved float32 meshes, which placed blobs hold.
#include <algorithm>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerLookup = 4e-7;
constexpr int kExpectedIterations = 15;

/// A vertex of the base mesh looked up in every mesh.
double LookupsOfBase(const PlanState& state) {
  return state.VerticesOf(state.base) * static_cast<double>(state.ActiveCount());
}

class FidentisAlignStage final : public Stage {
 public:
  explicit FidentisAlignStage(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] std::string Name() const override { return name_; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return static_cast<int64_t>(state.batches.size());
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const Batch& batch = state.batches[static_cast<size_t>(task)];
    const int iterations = std::min(state.spec.icp.max_iterations, kExpectedIterations) + 1;
    return state.VerticesOf(batch.meshes) * iterations * kSecondsPerLookup;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const Batch& batch = state.batches[static_cast<size_t>(task)];
    Task made;
    made.kind = TaskKind::kAlign;
    made.arithmetic = Arithmetic::kFidentis;
    made.meshes = state.TaskMeshes(batch.meshes);
    made.reference = state.reference;
    if (!batch.placed.empty()) {
      made.alignments = {batch.alignment};
      made.partials = {batch.placed};
    }
    made.icp = state.spec.icp;
    made.wants_placed = true;
    made.counts_reference_index = task == 0;
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (size_t i = 0; i < results.size(); ++i) {
      state.batches[i].alignment = results[i].output;
      state.batches[i].placed = results[i].placed;
    }
    state.RejectAllOf(results);
    COHORT_RETURN_IF_ERROR(state.CheckEnoughLeft());
    // The variation map is drawn on the aligned base mesh, whatever the method.
    const JobMesh& base = state.meshes[static_cast<size_t>(state.base)];
    if (!base.rejection.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat("the base mesh ", base.mesh.name, " cannot be used: ", base.rejection));
    }
    return absl::OkStatus();
  }

 private:
  std::string name_;
};

class FidentisAverageStage final : public Stage {
 public:
  explicit FidentisAverageStage(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] std::string Name() const override { return name_; }
  [[nodiscard]] int64_t TaskCount(const PlanState& /*state*/) const override { return 1; }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    return LookupsOfBase(state) * kSecondsPerLookup;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t /*task*/) const override {
    Task made;
    made.kind = TaskKind::kAverage;
    made.arithmetic = Arithmetic::kFidentis;
    made.reference = state.reference;
    made.partials = state.PlacedOf(state.active);
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    state.reference = results.front().output;
    return absl::OkStatus();
  }

 private:
  std::string name_;
};

/// The surface of the variation map and its values.
class FidentisSummarizeStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "summarize"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& /*state*/) const override { return 1; }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    return 2 * LookupsOfBase(state) * kSecondsPerLookup;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t /*task*/) const override {
    Task made;
    made.kind = TaskKind::kSummarize;
    made.arithmetic = Arithmetic::kFidentis;
    made.targets = state.TaskMeshes(std::span(&state.base, 1));
    made.partials = state.PlacedOf(state.active);
    made.compare = state.spec.compare;
    made.compare.retention = Retention::kMetrics;
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    state.outputs.summary = results.front().output;
    state.outputs.variation_shape = results.front().second_output;
    // Without rounds that surface, the base mesh and one averaging step, is the only mean there is.
    state.outputs.mean_shape =
        state.spec.method == Method::kAverage ? state.reference : results.front().second_output;
    return absl::OkStatus();
  }
};

}  // namespace

std::unique_ptr<const Stage> MakeFidentisAlignStage(const std::string& name) {
  return std::make_unique<FidentisAlignStage>(name);
}

std::unique_ptr<const Stage> MakeFidentisAverageStage(const std::string& name) {
  return std::make_unique<FidentisAverageStage>(name);
}

std::unique_ptr<const Stage> MakeFidentisSummarizeStage() {
  return std::make_unique<FidentisSummarizeStage>();
}

}  // namespace cohort
