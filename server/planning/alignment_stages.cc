#include <algorithm>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kPoseSecondsPerVertex = 3e-7;
constexpr double kVariationSecondsPerVertex = 7e-8;
constexpr double kAverageSecondsPerVertex = 1e-8;
constexpr double kChooseSecondsPerMesh = 0.03;
constexpr double kChooseSecondsPerPair = 1e-5;
constexpr double kSecondsPerLookup = 1.5e-8;
constexpr int kExpectedIterations = 35;  ///< Most alignments have converged by then.

/// Batches that are to be aligned.
int64_t OpenBatchCount(const PlanState& state) {
  return static_cast<int64_t>(state.batches.size() - state.FirstOpenBatch());
}

const Batch& BatchAt(const PlanState& state, int64_t task) {
  return state.batches[state.FirstOpenBatch() + static_cast<size_t>(task)];
}

/// Takes in the alignments of each batch, then the rejections of all.
absl::Status AbsorbAlignments(PlanState& state, std::span<const TaskResult> results) {
  const size_t first = state.FirstOpenBatch();
  for (size_t i = 0; i < results.size(); ++i) {
    state.batches[first + i].alignment = results[i].output;
    state.batches[first + i].starts = results[i].alignments;
    state.batches[first + i].displacement = results[i].second_output;
  }
  state.RejectAllOf(results);
  COHORT_RETURN_IF_ERROR(state.CheckEnoughLeft());
  if (state.HasKeptFrame()) {
    return absl::OkStatus();  // The frame needs no mesh of this job.
  }
  const JobMesh& base = state.meshes[static_cast<size_t>(state.base)];
  // A mean shape does without its first reference; the other methods compare with the base mesh.
  if (!base.rejection.empty() && state.spec.method != Method::kAverage) {
    return absl::FailedPreconditionError(
        absl::StrCat("the base mesh ", base.mesh.name, " cannot be used: ", base.rejection));
  }
  return absl::OkStatus();
}

std::array<int64_t, 2> ReadsOfBatch(const PlanState& state, int64_t task) {
  return {BatchAt(state, task).meshes.front(), TaskTraits::kNothing};
}

double PoseCost(const PlanState& state, const Batch& batch) {
  return state.VerticesOf(batch.meshes) * kPoseSecondsPerVertex;
}

/// What landmark poses need.
void AddLandmarks(const PlanState& state, Task& task) {
  if (state.spec.pose == PoseMode::kLandmarks) {
    task.targets = state.TaskMeshes(std::span(&state.base, 1));
    task.landmarks = state.spec.landmarks;
  }
}

/// One task per batch: meshes, the reference, and where they were aligned before.
Task MakeBatchTask(TaskKind kind, const PlanState& state, int64_t task) {
  const Batch& batch = BatchAt(state, task);
  Task made;
  made.kind = kind;
  made.meshes = state.TaskMeshes(batch.meshes);
  made.reference = state.reference;
  made.starts = batch.starts;
  if (!batch.alignment.empty()) {
    made.alignments = {batch.alignment};
  }
  made.counts_reference_index = task == 0;
  return made;
}

/// Coarse poses alone; method each aligns from them to every mesh.
class PoseStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "pose"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return OpenBatchCount(state);
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    return PoseCost(state, BatchAt(state, task));
  }
  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    return ReadsOfBatch(state, task);
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made = MakeBatchTask(TaskKind::kPose, state, task);
    AddLandmarks(state, made);
    if (!made.landmarks.empty()) {
      made.icp = state.spec.icp;
    }
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      if (!result.output.empty()) {
        state.outputs.poses.push_back(result.output);
      }
    }
    return AbsorbAlignments(state, results);
  }
};

class AlignStage final : public Stage {
 public:
  AlignStage(std::string name, const AlignParts& parts) : name_(std::move(name)), parts_(parts) {}

  [[nodiscard]] std::string Name() const override { return name_; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return OpenBatchCount(state);
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const Batch& batch = BatchAt(state, task);
    const double of_reference =
        state.VerticesOf(state.base) * static_cast<double>(batch.meshes.size());
    double lookups = state.VerticesOf(batch.meshes) *
                     std::min(state.spec.icp.max_iterations, kExpectedIterations);
    if (parts_.displacement) {
      lookups += of_reference;
    }
    double cost = lookups * kSecondsPerLookup;
    if (parts_.pose) {
      cost += PoseCost(state, batch);
    }
    if (parts_.variation) {
      cost += of_reference * kVariationSecondsPerVertex;
    }
    return cost;
  }
  [[nodiscard]] bool IsKnown(const PlanState& state, int64_t /*task*/) const override {
    return IsSkipped(state);
  }
  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    return ReadsOfBatch(state, task);
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made = MakeBatchTask(TaskKind::kAlign, state, task);
    made.icp = state.spec.icp;
    made.undersampling = state.spec.undersampling;
    made.wants_displacement = parts_.displacement;
    if (parts_.pose) {
      made.wants_pose = true;
      AddLandmarks(state, made);
    }
    if (parts_.variation) {
      made.wants_variation = true;
      made.wants_correspondences = parts_.variation->correspondences;
      made.moves_reference = parts_.variation->last_shape == LastShape::kReferencePlusDisplacement;
      made.frame_center = state.FrameCenter();
    }
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    if (IsSkipped(state)) {
      return absl::OkStatus();
    }
    const auto keep = [](const Digest& blob, std::vector<Digest>& blobs) {
      if (!blob.empty()) {
        blobs.push_back(blob);
      }
    };
    for (size_t i = 0; i < results.size(); ++i) {
      const TaskResult& result = results[i];
      keep(result.poses, state.outputs.poses);
      const Batch& batch = BatchAt(state, static_cast<int64_t>(i));
      const bool is_left = result.rejections.size() < batch.meshes.size();
      if (parts_.variation && is_left) {
        keep(result.variation, state.variations);
        keep(result.fields, state.outputs.signatures);
      }
    }
    return AbsorbAlignments(state, results);
  }

 private:
  /// A round that the mean shape no longer needs; the last alignment always runs.
  [[nodiscard]] bool IsSkipped(const PlanState& state) const {
    return state.mean_has_settled && parts_.displacement;
  }

  std::string name_;
  AlignParts parts_;
};

class AverageStage final : public Stage {
 public:
  explicit AverageStage(std::string name) : name_(std::move(name)) {}

  [[nodiscard]] std::string Name() const override { return name_; }
  [[nodiscard]] int64_t TaskCount(const PlanState& /*state*/) const override { return 1; }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    return state.VerticesOf(state.base) * static_cast<double>(state.batches.size()) *
           kAverageSecondsPerVertex;
  }
  [[nodiscard]] bool IsKnown(const PlanState& state, int64_t /*task*/) const override {
    return state.mean_has_settled;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t /*task*/) const override {
    Task made;
    made.kind = TaskKind::kAverage;
    made.reference = state.reference;
    for (const Batch& batch : state.batches) {
      made.partials.push_back(batch.displacement);
    }
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    if (!state.mean_has_settled) {
      state.reference = results.front().output;
      const double tolerance = state.spec.mean_tolerance;
      state.mean_has_settled = tolerance > 0 && results.front().change <= tolerance;
    }
    return absl::OkStatus();
  }

 private:
  std::string name_;
};

/// Base rule auto: one task that sees all meshes.
class ChooseBaseStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "base"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& /*state*/) const override { return 1; }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    const auto meshes = static_cast<double>(state.ActiveCount());
    return meshes * kChooseSecondsPerMesh + meshes * meshes * kChooseSecondsPerPair;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t /*task*/) const override {
    Task made;
    made.kind = TaskKind::kChooseBase;
    made.meshes = state.TaskMeshes(state.active);
    made.icp = state.spec.icp;
    made.landmarks = state.spec.landmarks;
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    state.base = results.front().base;
    state.reference = state.BlobOf(state.base);
    state.outputs.base_choice = results.front().output;
    return absl::OkStatus();
  }
};

}  // namespace

std::unique_ptr<const Stage> MakeChooseBaseStage() {
  return std::make_unique<ChooseBaseStage>();
}

std::unique_ptr<const Stage> MakePoseStage() {
  return std::make_unique<PoseStage>();
}

std::unique_ptr<const Stage> MakeAlignStage(const std::string& name, const AlignParts& parts) {
  return std::make_unique<AlignStage>(name, parts);
}

std::unique_ptr<const Stage> MakeAverageStage(const std::string& name) {
  return std::make_unique<AverageStage>(name);
}

}  // namespace cohort
