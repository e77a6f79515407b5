#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/job_frame.h"
#include "common/base/executor.h"

namespace cohort {

/// What measuring some pairs of a job once more has shown.
struct PairProof {
  int64_t pairs = 0;                     ///< Directed pairs that were measured again.
  int64_t of = 0;                        ///< Directed pairs of the job.
  int64_t numbers = 0;                   ///< Values compared, bit by bit: all metrics of each pair.
  std::vector<std::string> differences;  ///< One line each; empty: every bit is the same.
};

/// Draws `count` directed pairs of a job (all, if it has no more) and measures them once more from
/// its meshes and alignments.
/// @return kFailedPrecondition as JobFrame::CheckHasFrame.
[[nodiscard]] absl::StatusOr<PairProof> ProvePairs(
    Session& session, const JobFrame& frame, int64_t count, uint64_t seed, Executor& executor);

}  // namespace cohort
