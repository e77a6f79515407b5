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

std::vector<Task> StagedPlan::TakeReadyTasks() {
  std::vector<Task> tasks;
  for (size_t place = 0; place < open_.size(); ++place) {
    if (open_[place].fate == OpenTask::Fate::kReady) {
      open_[place].fate = OpenTask::Fate::kTaken;
      tasks.push_back(MakeTask(place));
    }
  }
  return tasks;
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
  COHORT_RETURN_IF_ERROR(CheckResult(state_, MakeTask(place), result));
  open.fate = OpenTask::Fate::kFinished;
  results_[place] = result;
  counters_ += result.counters;
  ++finished_.tasks;
  finished_.cost += open.cost;
  --unfinished_;
  return Advance();
}

Progress StagedPlan::CurrentProgress() const {
  Progress progress;
  const auto unfinished = std::find_if(open_.begin(), open_.end(), [](const OpenTask& open) {
    return open.fate != OpenTask::Fate::kFinished;
  });
  if (unfinished != open_.end()) {
    progress.stage = unfinished->stage->Name();
  }
  progress.tasks_done = closed_.tasks + finished_.tasks;
  progress.tasks_total = closed_.tasks + current_.tasks + announced_.tasks;
  progress.cost_total = closed_.cost + current_.cost + announced_.cost;
  // Results come in any order; rounding must not show more than all as done.
  progress.cost_done = std::min(closed_.cost + finished_.cost, progress.cost_total);
  return progress;
}

Task StagedPlan::MakeTask(size_t place) const {
  const OpenTask& open = open_[place];
  Task task = open.stage->MakeTask(state_, open.place);
  task.number = first_number_ + static_cast<int64_t>(place);
  task.stage = open.stage->Name();
  task.cost = open.cost;
  return task;
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
  announced_ = AnnouncedAfter(step_);
  if (!Done()) {
    for (const std::unique_ptr<const Stage>& stage : steps_[step_]) {
      for (int64_t place = 0; place < stage->TaskCount(state_); ++place) {
        OpenTask& open = open_.emplace_back();
        open.stage = stage.get();
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
  results_.assign(open_.size(), {});
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
