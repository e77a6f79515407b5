#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "server/planning/job_plan.h"
#include "server/planning/plan_state.h"
#include "server/planning/plan_steps.h"

namespace cohort {

/// A plan that goes through its steps one after another: numbers their tasks, collects the results
/// of a step, and hands them to its stages in task order once all are in.
class StagedPlan final : public JobPlan {
 public:
  /// @param state  spec, meshes (with what is known of them) and a provisional base.
  /// @return kFailedPrecondition if all meshes are known and the job cannot go on.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<JobPlan>> Start(PlanState state,
                                                                      std::vector<Step> steps);

  [[nodiscard]] std::vector<TaskRange> TakeReady() override;
  [[nodiscard]] Task MakeTask(int64_t number) const override;
  [[nodiscard]] TaskTraits TraitsOf(int64_t number) const override;
  [[nodiscard]] std::string StageOf(int64_t number) const override;
  [[nodiscard]] absl::Status Check(int64_t number, const TaskResult& result) const override;
  [[nodiscard]] absl::Status TaskFinished(int64_t number, const TaskResult& result) override;
  [[nodiscard]] bool Done() const override { return step_ == steps_.size(); }
  [[nodiscard]] double CostOf(int64_t number) const override;
  [[nodiscard]] JobForecast Forecast() const override;
  [[nodiscard]] Progress CurrentProgress() const override;
  [[nodiscard]] const Counters& TotalCounters() const override { return counters_; }
  [[nodiscard]] const std::vector<JobMesh>& Meshes() const override { return state_.meshes; }
  [[nodiscard]] const JobOutputs& Outputs() const override { return state_.outputs; }

 private:
  /// A task of the current step.
  struct OpenTask {
    const Stage* stage = nullptr;
    int64_t place = 0;  ///< In its stage.
    double cost = 0;
    int32_t stage_ordinal = 0;  ///< Of its stage in the step.
    enum class Fate : uint8_t { kReady, kTaken, kFinished } fate = Fate::kReady;
  };
  /// A number of tasks and what they cost.
  struct Load {
    int64_t tasks = 0;
    double cost = 0;
  };

  StagedPlan(PlanState state, std::vector<Step> steps);
  /// Opens the step `step_`, and those after it as long as all their tasks are finished.
  [[nodiscard]] absl::Status Advance();
  void OpenStep();
  [[nodiscard]] absl::Status AbsorbStep();
  [[nodiscard]] Load AnnouncedAfter(size_t step) const;

  PlanState state_;
  std::vector<Step> steps_;
  size_t step_ = 0;
  int64_t first_number_ = 0;  ///< Of the tasks of the current step.
  std::vector<OpenTask> open_;
  bool all_taken_ = false;           ///< None of `open_` is Fate::kReady.
  std::vector<TaskResult> results_;  ///< Of `open_`, place by place.
  int64_t unfinished_ = 0;
  size_t first_unfinished_ = 0;  ///< In `open_`.
  Load closed_;     ///< Of the steps before; summed in task order, so that it is always the same.
  Load current_;    ///< Of the current step.
  Load finished_;   ///< Its finished part.
  Load announced_;  ///< Of the steps to come, as foreseen now.
  Counters counters_;
};

}  // namespace cohort
