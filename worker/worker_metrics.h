#pragma once

#include <cstdint>

#include "common/metrics/metric_page.h"
#include "worker/worker_loop.h"

namespace cohort {

/// The page of a cohort-worker; README lists its metrics.
/// @param cache_bytes  decoded meshes kept.
[[nodiscard]] MetricPage MakeWorkerPage(const WorkerFigures& figures,
                                        int64_t cache_bytes,
                                        double start_unix_seconds);

}  // namespace cohort
