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

/// A lease as its worker reports it.
struct HeldTask {
  static constexpr int64_t kNotBegun = -1;
  Lease lease;
  int64_t ticks = kNotBegun;  ///< Grows while the task gets on: one for each mesh, pair, ...
  friend bool operator==(const HeldTask&, const HeldTask&) = default;
};

}  // namespace cohort
