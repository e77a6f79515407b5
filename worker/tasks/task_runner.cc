#include "worker/tasks/task_runner.h"

#include <chrono>
#include <exception>
#include <new>
#include <string>

#include "common/base/status_macros.h"
#include "worker/tasks/align_task.h"
#include "worker/tasks/choose_base_task.h"
#include "worker/tasks/compare_task.h"
#include "worker/tasks/fidentis_tasks.h"
#include "worker/tasks/ingest_task.h"
#include "worker/tasks/preview_task.h"
#include "worker/tasks/symmetrize_task.h"
#include "worker/tasks/task_context.h"
#include "worker/tasks/variation_task.h"

namespace cohort {
namespace {

absl::StatusOr<TaskResult> DispatchFidentis(const Task& task, const TaskContext& context) {
  switch (task.kind) {
    case TaskKind::kAlign:
      return RunFidentisAlignTask(task, context);
    case TaskKind::kAverage:
      return RunFidentisAverageTask(task, context);
    case TaskKind::kCompare:
      return RunFidentisCompareTask(task, context);
    case TaskKind::kAlignAndCompare:
      return RunFidentisAlignAndCompareTask(task, context);
    case TaskKind::kSummarize:
      return RunFidentisSummarizeTask(task, context);
    default:
      return absl::InvalidArgumentError("a task \"" + std::string(TaskKindName(task.kind)) +
                                        "\" is not one of the arithmetic fidentis");
  }
}

absl::StatusOr<TaskResult> Dispatch(const Task& task, const TaskContext& context) {
  if (task.arithmetic == Arithmetic::kFidentis) {
    return DispatchFidentis(task, context);
  }
  switch (task.kind) {
    case TaskKind::kIngest:
      return RunIngestTask(task, context);
    case TaskKind::kPose:
      return RunPoseTask(task, context);
    case TaskKind::kAlign:
      return RunAlignTask(task, context);
    case TaskKind::kAverage:
      return RunAverageTask(task, context);
    case TaskKind::kCompare:
      return RunCompareTask(task, context);
    case TaskKind::kAlignAndCompare:
      return RunAlignAndCompareTask(task, context);
    case TaskKind::kVariation:
      return RunVariationTask(task, context);
    case TaskKind::kSummarize:
      return RunSummarizeTask(task, context);
    case TaskKind::kChooseBase:
      return RunChooseBaseTask(task, context);
    case TaskKind::kPreview:
      return RunPreviewTask(task, context);
    case TaskKind::kSymmetrize:
      return RunSymmetrizeTask(task, context);
  }
  return absl::InvalidArgumentError("task kind " + std::to_string(static_cast<int>(task.kind)) +
                                    " is not known");
}

}  // namespace

absl::StatusOr<TaskResult> TaskRunner::Run(const Task& task,
                                           std::stop_token stop,
                                           std::atomic<int64_t>& ticks,
                                           const TaskHooks& hooks) {
  COHORT_ASSIGN_OR_RETURN(ComputeSlots::Permit permit, slots_.Acquire(stop));
  ticks = 0;
  if (hooks.on_begin) {
    hooks.on_begin();
  }
  const auto start = std::chrono::steady_clock::now();
  try {
    absl::StatusOr<TaskResult> result = Dispatch(task, {.store = store_,
                                                        .meshes = meshes_,
                                                        .stop = std::move(stop),
                                                        .permit = permit,
                                                        .ticks = ticks,
                                                        .on_computed = hooks.on_computed});
    if (result.ok()) {
      result->seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    return result;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("out of memory in task " + std::to_string(task.number) +
                                        " (" + task.stage + ")");
  } catch (const std::exception& error) {
    return absl::InternalError("task " + std::to_string(task.number) + " (" + task.stage +
                               "): " + error.what());
  }
}

}  // namespace cohort
