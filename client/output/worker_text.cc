#include "client/output/worker_text.h"

#include <algorithm>
#include <cstdint>

#include <absl/strings/str_cat.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/output/job_text.h"
#include "client/output/progress_line.h"
#include "common/report/job_json.h"

namespace cohort {
namespace {

constexpr double kSilentSeconds = 30;  ///< Three times as long as between two calls.

bool IsComputing(const RunningTask& task) {
  return task.held.ticks != HeldTask::kNotBegun;
}

int64_t Computing(const WorkerStatus& worker) {
  return std::count_if(worker.running.begin(), worker.running.end(), IsComputing);
}

std::string StateOf(const WorkerStatus& worker) {
  if (worker.silent_seconds > kSilentSeconds) {
    return absl::StrCat("silent ", FormatDuration(worker.silent_seconds));
  }
  return worker.is_draining ? "draining" : Computing(worker) > 0 ? "busy" : "idle";
}

}  // namespace

nlohmann::json WorkersToJson(const std::vector<WorkerStatus>& workers) {
  nlohmann::json list = nlohmann::json::array();
  for (const WorkerStatus& worker : workers) {
    nlohmann::json running = nlohmann::json::array();
    for (const RunningTask& task : worker.running) {
      running.push_back({{"job", task.held.lease.task.job.value},
                         {"task", task.held.lease.task.number},
                         {"stage", task.stage},
                         {"begun", IsComputing(task)},
                         {"seconds", task.seconds}});
    }
    list.push_back({{"name", worker.worker.value},
                    {"state", StateOf(worker)},
                    {"instruction_set", worker.instruction_set},
                    {"slots", worker.slots},
                    {"silent_seconds", worker.silent_seconds},
                    {"first_seen", Iso8601Utc(worker.first_seen_unix_ms)},
                    {"tasks_done", worker.tasks_done},
                    {"tasks_failed", worker.tasks_failed},
                    {"busy_seconds", worker.busy_seconds},
                    {"running", std::move(running)}});
  }
  return list;
}

std::string WorkersToTable(const std::vector<WorkerStatus>& workers) {
  size_t width = 6;
  for (const WorkerStatus& worker : workers) {
    width = std::max(width, worker.worker.value.size());
  }
  std::string table = fmt::format("{:<{}}  {:<12} {:>7} {:>8} {:>8} {:>10}  {}\n", "worker", width,
                                  "state", "slots", "done", "failed", "busy", "kernels");
  for (const WorkerStatus& worker : workers) {
    table += fmt::format("{:<{}}  {:<12} {:>3} / {:<1} {:>8} {:>8} {:>10}  {}\n",
                         worker.worker.value, width, StateOf(worker), Computing(worker),
                         worker.slots, worker.tasks_done, worker.tasks_failed,
                         FormatDuration(worker.busy_seconds), worker.instruction_set);
  }
  return table;
}

std::string Overview(const std::vector<Job>& jobs,
                     const std::vector<WorkerStatus>& workers,
                     size_t most_tasks) {
  int64_t slots = 0;
  int64_t computing = 0;
  std::vector<std::pair<const RunningTask*, const WorkerStatus*>> tasks;
  for (const WorkerStatus& worker : workers) {
    slots += worker.slots;
    computing += Computing(worker);
    for (const RunningTask& task : worker.running) {
      if (IsComputing(task)) {
        tasks.emplace_back(&task, &worker);
      }
    }
  }
  std::vector<Job> open;
  std::copy_if(jobs.begin(), jobs.end(), std::back_inserter(open),
               [](const Job& job) { return !IsFinal(job.state); });
  std::string text = fmt::format("{} workers, {} of {} slots compute, {} jobs under way\n",
                                 workers.size(), computing, slots, open.size());
  if (!open.empty()) {
    absl::StrAppend(&text, "\n", JobsToTable(open));
  }
  std::sort(tasks.begin(), tasks.end(),
            [](const auto& a, const auto& b) { return a.first->seconds > b.first->seconds; });
  if (!tasks.empty()) {
    text +=
        fmt::format("\n{:<10} {:>9} {:<14} {:>9}  {}\n", "job", "task", "stage", "for", "worker");
  }
  for (size_t i = 0; i < std::min(tasks.size(), most_tasks); ++i) {
    const auto& [task, worker] = tasks[i];
    text += fmt::format("{:<10} {:>9} {:<14} {:>9}  {}\n", task->held.lease.task.job.value,
                        task->held.lease.task.number, task->stage.empty() ? "-" : task->stage,
                        FormatDuration(task->seconds), worker->worker.value);
  }
  if (tasks.size() > most_tasks) {
    text += fmt::format("... and {} more\n", tasks.size() - most_tasks);
  }
  return text;
}

}  // namespace cohort
