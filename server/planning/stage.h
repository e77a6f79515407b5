#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <absl/status/status.h>

#include "common/jobs/task.h"
#include "server/planning/plan_state.h"

namespace cohort {

/// Tasks of one kind that do not depend on each other. A stage keeps no state of its own: its tasks
/// are numbered 0..TaskCount()-1 and made from the plan's state whenever they are asked for, so
/// that a plan of a million tasks stays small.
class Stage {
 public:
  virtual ~Stage() = default;

  /// "align 2".
  [[nodiscard]] virtual std::string Name() const = 0;
  /// Before the stage is reached: as far as the state foresees it.
  [[nodiscard]] virtual int64_t TaskCount(const PlanState& state) const = 0;
  /// Rough seconds; as TaskCount, also for stages to come.
  [[nodiscard]] virtual double TaskCost(const PlanState& state, int64_t task) const = 0;
  /// True if what the task would find out is known: it counts as finished and is never handed out.
  [[nodiscard]] virtual bool IsKnown(const PlanState& /*state*/, int64_t /*task*/) const {
    return false;
  }
  /// Only when all steps before are finished. Number, stage and cost are filled in by the plan.
  [[nodiscard]] virtual Task MakeTask(const PlanState& state, int64_t task) const = 0;
  /// TaskTraits::reads.
  [[nodiscard]] virtual std::array<int64_t, 2> Reads(const PlanState& /*state*/,
                                                     int64_t /*task*/) const {
    return {TaskTraits::kNothing, TaskTraits::kNothing};
  }
  /// Takes in the results of all tasks, in order, and makes the state ready for the next step.
  /// @return kFailedPrecondition, the job's error, if the job cannot go on.
  [[nodiscard]] virtual absl::Status Absorb(PlanState& state,
                                            std::span<const TaskResult> results) const = 0;
};

/// Whether the last shape is made from the base mesh or is there already.
enum class LastShape { kReferencePlusDisplacement, kReference };

/// What is to be found of the distances of the reference's vertices to aligned meshes.
struct VariationParts {
  LastShape last_shape = LastShape::kReference;
  bool correspondences = false;  ///< All displacements are kept, for a preview.
};

/// What an alignment does besides aligning.
struct AlignParts {
  /// Coarse poses come first: no others are known.
  bool pose = false;
  /// A round of the mean shape: it also says how far the reference is from the mean.
  bool displacement = false;
  /// The last alignment: the variation around the reference too.
  std::optional<VariationParts> variation = {};
};

[[nodiscard]] std::unique_ptr<const Stage> MakeIngestStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeSymmetrizeStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeChooseBaseStage();
[[nodiscard]] std::unique_ptr<const Stage> MakePoseStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeAlignStage(const std::string& name,
                                                          const AlignParts& parts);
[[nodiscard]] std::unique_ptr<const Stage> MakeAverageStage(const std::string& name);
[[nodiscard]] std::unique_ptr<const Stage> MakeCompareStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeAlignAndCompareStage();
// Of Arithmetic::kFidentis, besides those of ingest and comparison.
[[nodiscard]] std::unique_ptr<const Stage> MakeFidentisAlignStage(const std::string& name);
[[nodiscard]] std::unique_ptr<const Stage> MakeFidentisAverageStage(const std::string& name);
[[nodiscard]] std::unique_ptr<const Stage> MakeFidentisSummarizeStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeVariationStage(const VariationParts& parts);
[[nodiscard]] std::unique_ptr<const Stage> MakePreviewStage();
[[nodiscard]] std::unique_ptr<const Stage> MakeSummarizeStage(LastShape last_shape);

}  // namespace cohort
