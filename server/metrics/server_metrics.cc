#include "server/metrics/server_metrics.h"

#include <string>
#include <vector>

namespace cohort {
namespace {

void AddTasks(const CoordinatorFigures& figures, MetricPage& page) {
  const EventTotals& totals = figures.totals;
  page.AddGauge("cohort_tasks_ready", "Tasks that wait for a worker, or to be tried again.",
                static_cast<double>(figures.tasks_ready));
  page.AddGauge("cohort_tasks_leased", "Tasks that workers hold.",
                static_cast<double>(figures.tasks_leased));
  page.AddGauge("cohort_tasks_ready_wait_seconds",
                "How long tasks have been ready while none was handed out; 0: none is ready.",
                figures.ready_wait_seconds);
  std::vector<MetricValue> completed;
  std::vector<MetricValue> seconds;
  for (const auto& [kind, done] : totals.done) {
    completed.push_back({.value = static_cast<double>(done.count), .labels = {{"stage", kind}}});
    seconds.push_back({.value = done.seconds, .labels = {{"stage", kind}}});
  }
  page.AddCounter("cohort_tasks_completed_total", "Results taken, by the kind of stage.",
                  completed);
  page.AddCounter("cohort_task_seconds_total",
                  "What workers took for the tasks completed, by the kind of stage.", seconds);
  page.AddCounter("cohort_tasks_failed_total", "Attempts that failed; most are tried again.",
                  static_cast<double>(totals.tasks_failed));
  page.AddCounter("cohort_tasks_lost_total", "Attempts lost with their workers.",
                  static_cast<double>(totals.tasks_lost));
  page.AddCounter("cohort_tasks_given_up_total", "Tasks that failed or were lost too often.",
                  static_cast<double>(totals.tasks_given_up));
  page.AddCounter("cohort_tasks_superseded_total",
                  "Results not taken: the task was done already, or not wanted any more.",
                  static_cast<double>(totals.tasks_superseded));
  page.AddCounter("cohort_tasks_reused_total",
                  "Tasks not done because an earlier job's results were known.",
                  static_cast<double>(totals.tasks_reused));
  page.AddCounter("cohort_task_second_copies_total", "Second copies handed out of slow tasks.",
                  static_cast<double>(figures.second_copies));
}

void AddJobs(const CoordinatorFigures& figures, MetricPage& page) {
  std::vector<MetricValue> jobs;
  for (const auto& [state, count] : figures.jobs) {
    jobs.push_back({.value = static_cast<double>(count),
                    .labels = {{"state", std::string(JobStateName(state))}}});
  }
  page.AddGauge("cohort_jobs", "Jobs that have not ended, by state.", jobs);
  std::vector<MetricValue> ended;
  for (const JobState state : {JobState::kSucceeded, JobState::kFailed, JobState::kCancelled}) {
    const auto found = figures.totals.jobs_ended.find(state);
    const int64_t count = found == figures.totals.jobs_ended.end() ? 0 : found->second;
    ended.push_back({.value = static_cast<double>(count),
                     .labels = {{"state", std::string(JobStateName(state))}}});
  }
  page.AddCounter("cohort_jobs_ended_total", "Jobs that have ended, by how.", ended);
}

void AddWorkers(const CoordinatorFigures& figures, MetricPage& page) {
  page.AddGauge("cohort_workers", "Workers heard of within a lease time.",
                static_cast<double>(figures.workers));
  page.AddGauge("cohort_workers_draining", "Those of them that take no more tasks.",
                static_cast<double>(figures.workers_draining));
  page.AddGauge("cohort_worker_slots", "Tasks that the workers compute at once.",
                static_cast<double>(figures.slots));
  page.AddGauge("cohort_worker_slots_busy", "Tasks that they compute.",
                static_cast<double>(figures.slots_busy));
}

}  // namespace

MetricPage MakeServerPage(const CoordinatorFigures& figures, const ServerState& server) {
  MetricPage page;
  page.AddProcess("cohort-server", server.start_unix_seconds);
  AddTasks(figures, page);
  AddJobs(figures, page);
  AddWorkers(figures, page);
  page.AddHistogram("cohort_synchronize_seconds",
                    "Workers' Synchronize calls, without the time they wait for a task.",
                    figures.synchronize);
  page.AddHistogram("cohort_complete_task_seconds", "Workers' CompleteTask calls.",
                    figures.complete);
  page.AddHistogram("cohort_catalog_write_seconds",
                    "Transactions that write to the catalog, until they are on disk.",
                    figures.catalog_writes);
  if (server.store_free_bytes) {
    page.AddGauge("cohort_store_free_bytes", "Free on the disk of the blob store.",
                  static_cast<double>(*server.store_free_bytes));
  }
  return page;
}

}  // namespace cohort
