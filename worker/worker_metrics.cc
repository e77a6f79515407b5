#include "worker/worker_metrics.h"

namespace cohort {

MetricPage MakeWorkerPage(const WorkerFigures& figures,
                          int64_t cache_bytes,
                          double start_unix_seconds) {
  MetricPage page;
  page.AddProcess("cohort-worker", start_unix_seconds);
  page.AddGauge("cohort_worker_slots", "Tasks that the worker computes at once.", figures.slots);
  page.AddGauge("cohort_worker_slots_busy", "Tasks that it computes.",
                static_cast<double>(figures.computing));
  page.AddGauge("cohort_worker_tasks_held", "Tasks that it holds; those that wait for a slot, too.",
                static_cast<double>(figures.held));
  page.AddCounter("cohort_worker_tasks_completed_total", "Tasks done and reported.",
                  static_cast<double>(figures.completed));
  page.AddCounter("cohort_worker_tasks_failed_total", "Tasks that failed here.",
                  static_cast<double>(figures.failed));
  page.AddCounter("cohort_worker_tasks_released_total",
                  "Tasks given back when the worker ended, or that it was told to stop.",
                  static_cast<double>(figures.released));
  page.AddCounter("cohort_worker_task_seconds_total", "What the tasks completed took.",
                  figures.seconds);
  page.AddGauge("cohort_worker_cache_bytes", "Decoded meshes kept in memory.",
                static_cast<double>(cache_bytes));
  return page;
}

}  // namespace cohort
