#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"
#include "common/base/executor.h"

namespace cohort {

struct PermanovaOptions {
  int64_t permutations = 9999;
  uint64_t seed = 1;

  /// @return kInvalidArgument if there is no permutation, or over 10 million.
  [[nodiscard]] absl::Status Validate() const;
};

/// One row for the groups, one for the rest, one for all, as an analysis of variance has them.
struct Permanova {
  int64_t meshes = 0;  ///< Those with a group.
  int64_t groups = 0;
  double sum_of_squares_groups = 0;  ///< Unit of the metric, squared.
  double sum_of_squares_residual = 0;
  double sum_of_squares_total = 0;
  double r_squared = 0;  ///< Groups / total.
  double f = 0;          ///< (groups / (g - 1)) / (residual / (n - g)); infinite without residual.
  double p = 0;          ///< (1 + as_extreme) / (1 + permutations).
  int64_t as_extreme = 0;
  int64_t permutations = 0;
};

/// Do the groups differ? Analysis of variance of distances by one factor, with the groups shuffled
/// among the meshes. Meshes without a group ("") are left out; a group of one mesh counts.
///
/// O(N^2) a permutation; any executor gives the same bytes.
/// @param groups  one per row.
/// @return kInvalidArgument if the groups are not one per row, all labelled meshes are of one
///         group, or each is a group of its own; as RequireDissimilarities (3 meshes with a group)
///         and RequireComplete; kFailedPrecondition if all distances are zero.
/// Source: Anderson 2001; vegan::adonis2.
[[nodiscard]] absl::StatusOr<Permanova> TestGroups(const MetricMatrix& distances,
                                                   std::span<const std::string> groups,
                                                   const PermanovaOptions& options,
                                                   Executor& executor);

}  // namespace cohort
