#pragma once

#include <cstdint>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"
#include "common/base/executor.h"

namespace cohort {

/// Of the values as they are, or of their ranks (ties get the mean rank).
enum class Correlation { kPearson, kSpearman };
/// What counts as at least as extreme as the statistic found: as large, or as far from zero.
enum class Alternative { kGreater, kTwoSided };

struct MantelOptions {
  Correlation correlation = Correlation::kPearson;
  Alternative alternative = Alternative::kGreater;
  int64_t permutations = 9999;
  uint64_t seed = 1;

  /// @return kInvalidArgument if there is no permutation, or over 10 million.
  [[nodiscard]] absl::Status Validate() const;
};

struct MantelResult {
  double r = 0;  ///< Correlation of the pairs; of three matrices the partial one.
  /// (1 + as_extreme) / (1 + permutations); 1 at most, 1 / (1 + permutations) at least.
  double p = 0;
  int64_t as_extreme = 0;
  int64_t permutations = 0;
  int64_t meshes = 0;
};

/// Do two matrices over the same meshes go together? Correlation of the pairs below the diagonal
/// against that after permuting the meshes of `a` at random. A permutation whose statistic is under
/// the one found by less than 1.5e-8 counts as extreme (sums in another order differ in the last
/// digits; vegan's rule).
///
/// Permutation i depends on seed and i only. O(N^2) for each, one after the other's result, so any
/// executor gives the same bytes.
/// @param a, b  symmetric, same labels in the same order, complete; any values (also similarities).
/// @return kInvalidArgument if the labels differ or the options are invalid; as RequireSymmetric
///         (3 meshes) and RequireComplete; kFailedPrecondition if a matrix is constant.
/// Source: Mantel 1967; Legendre, Legendre 2012 (p); vegan::mantel.
[[nodiscard]] absl::StatusOr<MantelResult> MantelTest(const MetricMatrix& a,
                                                      const MetricMatrix& b,
                                                      const MantelOptions& options,
                                                      Executor& executor);

/// The same of `a` and `b` with what both owe to `given` taken out:
/// r = (r_ab - r_ac r_bc) / sqrt((1 - r_ac^2) (1 - r_bc^2)).
/// @return also kFailedPrecondition if `given` is, but for scale and shift, one of the others.
/// Source: Smouse, Long, Sokal 1986; vegan::mantel.partial.
[[nodiscard]] absl::StatusOr<MantelResult> PartialMantelTest(const MetricMatrix& a,
                                                             const MetricMatrix& b,
                                                             const MetricMatrix& given,
                                                             const MantelOptions& options,
                                                             Executor& executor);

}  // namespace cohort
