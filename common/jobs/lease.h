#pragma once

#include <cstdint>

#include "common/jobs/ids.h"

namespace cohort {

/// Right to run one task until it expires unrenewed. The epoch grows with every grant of the task,
/// so that a late answer can be told from a current one.
struct Lease {
  TaskId task;
  int64_t epoch = 0;
  friend bool operator==(const Lease&, const Lease&) = default;
  friend auto operator<=>(const Lease&, const Lease&) = default;
};

}  // namespace cohort
