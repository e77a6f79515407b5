#pragma once

#include <cstdint>
#include <optional>

#include "common/metrics/metric_page.h"
#include "server/core/coordinator_figures.h"

namespace cohort {

/// What the server tells of itself beside its coordinator's figures.
struct ServerState {
  double start_unix_seconds = 0;
  std::optional<int64_t> store_free_bytes;  ///< Nothing: not known.
};

/// The page of a cohort-server; README lists its metrics.
[[nodiscard]] MetricPage MakeServerPage(const CoordinatorFigures& figures,
                                        const ServerState& server);

}  // namespace cohort
