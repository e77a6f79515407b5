#include "server/planning/staged_plan.h"

#include <algorithm>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "server/planning/result_check.h"

namespace cohort {

StagedPlan::StagedPlan(PlanState state, std::vector<Step> steps)
    : state_(std::move(state)), steps_(std::move(steps)) {}

absl::StatusOr<std::unique_ptr<JobPlan>> StagedPlan::Start(PlanState state,
                                                           std::vector<Step> steps) {
  std::unique_ptr<StagedPlan> plan(new StagedPlan(std::move(state), std::move(steps)));
  plan->OpenStep();
  COHORT_RETURN_IF_ERROR(plan->Advance());
  return plan;
}

std::vector<TaskRange> StagedPlan::TakeReady() {
  std::vector<TaskRange> ranges;
  if (all_taken_) {
    return ranges;
  }
  all_taken_ = true;
  for (size_t place = 0; place < open_.size(); ++place) {
    if (open_[place].fate != OpenTask::Fate::kReady) {
      continue;
    }
    open_[place].fate = OpenTask::Fate::kTaken;
    const int64_t number = first_number_ + static_cast<int64_t>(place);
    if (ranges.empty() || ranges.back().first + ranges.back().count != number) {
      ranges.push_back({.first = number, .count = 0});
    }
    ++ranges.back().count;
  }
  return ranges;
}

std::string StagedPlan::StageOf(int64_t number) const {
  return open_.at(static_cast<size_t>(number - first_number_)).stage->Name();
}

absl::Status StagedPlan::Check(int64_t number, const TaskResult& result) const {
  if (number < first_number_ || number >= first_number_ + std::ssize(open_)) {
    return absl::NotFoundError(absl::StrCat("the step has no task ", number));
  }
  return CheckResult(state_, MakeTask(number), result);
}

absl::Status StagedPlan::TaskFinished(int64_t number, const TaskResult& result) {
  if (number < 0 || number >= first_number_ + static_cast<int64_t>(open_.size())) {
    return absl::NotFoundError(absl::StrCat("the plan has no task ", number));
  }
  if (number < first_number_) {
    return absl::OkStatus();  // Of a finished step: a second result.
  }
  const auto place = static_cast<size_t>(number - first_number_);
  OpenTask& open = open_[place];
  if (open.fate == OpenTask::Fate::kFinished) {
    return absl::OkStatus();
  }
  COHORT_RETURN_IF_ERROR(CheckResult(state_, MakeTask(number), result));
  open.fate = OpenTask::Fate::kFinished;
  results_[place] = result;
  counters_ += result.counters;
  ++finished_.tasks;
  finished_.cost += open.cost;
  --unfinished_;
  while (first_unfinished_ < open_.size() &&
         open_[first_unfinished_].fate == OpenTask::Fate::kFinished) {
    ++first_unfinished_;
  }
  return Advance();
}

Progress StagedPlan::CurrentProgress() const {
  Progress progress;
  if (first_unfinished_ < open_.size()) {
    progress.stage = open_[first_unfinished_].stage->Name();
  }
  progress.tasks_done = closed_.tasks + finished_.tasks;
  progress.tasks_total = closed_.tasks + current_.tasks + announced_.tasks;
  progress.cost_total = closed_.cost + current_.cost + announced_.cost;
  // Results come in any order; rounding must not show more than all as done.
  progress.cost_done = std::min(closed_.cost + finished_.cost, progress.cost_total);
  return progress;
}

double StagedPlan::CostOf(int64_t number) const {
  return open_.at(static_cast<size_t>(number - first_number_)).cost;
}

JobForecast StagedPlan::Forecast() const {
  JobForecast forecast = ForecastOf(state_);
  const auto add = [&](const Stage& stage, double cost) {
    const std::string name = stage.Name();
    if (forecast.stages.empty() || forecast.stages.back().name != name) {
      forecast.stages.push_back({.name = name, .tasks = 0, .cost = 0, .longest = 0});
    }
    StageForecast& last = forecast.stages.back();
    ++last.tasks;
    last.cost += cost;
    last.longest = std::max(last.longest, cost);
  };
  for (const OpenTask& open : open_) {
    if (open.fate != OpenTask::Fate::kFinished) {
      add(*open.stage, open.cost);
    }
  }
  for (size_t later = step_ + 1; later < steps_.size(); ++later) {
    for (const std::unique_ptr<const Stage>& stage : steps_[later]) {
      const int64_t tasks = stage->TaskCount(state_);
      for (int64_t place = 0; place < tasks; ++place) {
        add(*stage, stage->TaskCost(state_, place));
      }
    }
  }
  return forecast;
}

Task StagedPlan::MakeTask(int64_t number) const {
  const OpenTask& open = open_.at(static_cast<size_t>(number - first_number_));
  Task task = open.stage->MakeTask(state_, open.place);
  task.number = number;
  task.stage = open.stage->Name();
  task.cost = open.cost;
  return task;
}

TaskTraits StagedPlan::TraitsOf(int64_t number) const {
  if (number < first_number_ || number >= first_number_ + std::ssize(open_)) {
    return {};
  }
  const OpenTask& open = open_[static_cast<size_t>(number - first_number_)];
  // Numbers of a step are consecutive, so that one of them names the stage.
  return {.stage = first_number_ + open.stage_ordinal,
          .reads = open.stage->Reads(state_, open.place),
          .cost = open.cost};
}

absl::Status StagedPlan::Advance() {
  while (!Done() && unfinished_ == 0) {
    COHORT_RETURN_IF_ERROR(AbsorbStep());
    ++step_;
    OpenStep();
  }
  return absl::OkStatus();
}

void StagedPlan::OpenStep() {
  first_number_ += static_cast<int64_t>(open_.size());
  closed_.tasks += current_.tasks;
  closed_.cost += current_.cost;
  current_ = {};
  finished_ = {};
  unfinished_ = 0;
  open_.clear();
  all_taken_ = false;
  first_unfinished_ = 0;
  state_.active_vertices = state_.VerticesOf(state_.active);
  announced_ = AnnouncedAfter(step_);
  if (!Done()) {
    int32_t ordinal = -1;
    for (const std::unique_ptr<const Stage>& stage : steps_[step_]) {
      ++ordinal;
      const int64_t count = stage->TaskCount(state_);
      open_.reserve(open_.size() + static_cast<size_t>(count));
      for (int64_t place = 0; place < count; ++place) {
        OpenTask& open = open_.emplace_back();
        open.stage = stage.get();
        open.stage_ordinal = ordinal;
        open.place = place;
        if (stage->IsKnown(state_, place)) {
          open.fate = OpenTask::Fate::kFinished;
          continue;
        }
        open.cost = stage->TaskCost(state_, place);
        ++current_.tasks;
        current_.cost += open.cost;
        ++unfinished_;
      }
    }
  }
  while (first_unfinished_ < open_.size() &&
         open_[first_unfinished_].fate == OpenTask::Fate::kFinished) {
    ++first_unfinished_;
  }
  results_.clear();
  results_.resize(open_.size());
}

absl::Status StagedPlan::AbsorbStep() {
  const std::span<const TaskResult> all(results_);
  for (size_t begin = 0; begin < open_.size();) {
    const Stage* stage = open_[begin].stage;
    size_t end = begin;
    while (end < open_.size() && open_[end].stage == stage) {
      ++end;
    }
    COHORT_RETURN_IF_ERROR(stage->Absorb(state_, all.subspan(begin, end - begin)));
    begin = end;
  }
  return absl::OkStatus();
}

StagedPlan::Load StagedPlan::AnnouncedAfter(size_t step) const {
  Load load;
  for (size_t later = step + 1; later < steps_.size(); ++later) {
    for (const std::unique_ptr<const Stage>& stage : steps_[later]) {
      const int64_t tasks = stage->TaskCount(state_);
      load.tasks += tasks;
      for (int64_t place = 0; place < tasks; ++place) {
        load.cost += stage->TaskCost(state_, place);
      }
    }
  }
  return load;
}

}  // namespace cohort
