#pragma once

#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/jobs/job_state.h"
#include "common/jobs/task.h"
#include "server/planning/job_forecast.h"

namespace cohort {

/// Grows with every change of which tasks a job has and of their numbers, so that a server does not
/// take the results that another build wrote under the same numbers for those of its own plan.
/// tests/server/planning/plan_version_test.cc notices.
inline constexpr int kPlanVersion = 3;

/// Consecutive task numbers.
struct TaskRange {
  int64_t first = 0;
  int64_t count = 0;
  friend bool operator==(const TaskRange&, const TaskRange&) = default;
};

/// What a job still needs: which tasks are ready now, and what finishing one makes ready.
///
/// Pure and deterministic: no clock, no I/O, no knowledge of workers. Feeding the same results in
/// any order ends in the same plan, with the same task numbers. Not thread-safe; the coordinator's
/// lock covers it.
class JobPlan {
 public:
  /// @param meshes  in the job's order (by name, bytewise), names unique.
  /// @param known  results of earlier ingests by raw digest and position bits, with their index in
  ///               `meshes`; may be empty. Such meshes get no ingest task. Task numbers do not
  ///               depend on it: a plan made again after a restart, when more is known, fits its
  ///               results.
  /// @param kept  with a reference job: `frame`, `imported` (whose meshes are the kept ones), and
  ///              as `alignments` one blob of those.
  /// @return kInvalidArgument if the spec is invalid, there are fewer than 2 meshes, they are not
  /// in
  ///         order, the base is not among them, or `known` does not fit them; kFailedPrecondition
  ///         as TaskFinished if all meshes are known.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<JobPlan>> Create(
      const JobSpec& spec,
      const std::vector<SetMesh>& meshes,
      const std::vector<IngestedMesh>& known,
      const JobOutputs& kept = {});
  virtual ~JobPlan() = default;

  /// Tasks whose inputs exist and which were not returned before, ascending. They are numbers, so
  /// that a stage of a million tasks stays small; MakeTask tells what each is.
  [[nodiscard]] virtual std::vector<TaskRange> TakeReady() = 0;
  /// @param number  of the current step: as returned by TakeReady, while no later ones were.
  [[nodiscard]] virtual Task MakeTask(int64_t number) const = 0;
  /// @param number  as above; others have no traits.
  [[nodiscard]] virtual TaskTraits TraitsOf(int64_t number) const = 0;
  /// TakeReady with every task made; for small jobs.
  [[nodiscard]] std::vector<Task> TakeReadyTasks();

  /// @param number  as MakeTask.
  [[nodiscard]] virtual std::string StageOf(int64_t number) const = 0;
  /// What TaskFinished would refuse as not fitting, without recording anything.
  [[nodiscard]] virtual absl::Status Check(int64_t number, const TaskResult& result) const = 0;

  /// Records one result, also of a task that was not taken yet (restart). A second result for the
  /// same task is ignored (tasks run at least once).
  /// @return kNotFound if the task is not of this plan, or of a stage not reached yet;
  ///         kInvalidArgument if the result does not fit the task (nothing is recorded);
  ///         kFailedPrecondition if the job cannot go on (fewer than 2 meshes left, base rejected,
  ///         meshes in different units): the message is the job's error, naming the meshes.
  [[nodiscard]] virtual absl::Status TaskFinished(int64_t number, const TaskResult& result) = 0;

  [[nodiscard]] virtual bool Done() const = 0;
  /// Rough seconds (Task::cost). @param number  as MakeTask.
  [[nodiscard]] virtual double CostOf(int64_t number) const = 0;
  /// What all that is not finished takes, as far as the plan foresees it now.
  [[nodiscard]] virtual JobForecast Forecast() const = 0;
  [[nodiscard]] virtual Progress CurrentProgress() const = 0;
  [[nodiscard]] virtual const Counters& TotalCounters() const = 0;
  /// In the job's order, with what is known of each so far.
  [[nodiscard]] virtual const std::vector<JobMesh>& Meshes() const = 0;
  /// Valid when Done(); the preview as soon as it is not empty.
  [[nodiscard]] virtual const JobOutputs& Outputs() const = 0;
};

}  // namespace cohort
