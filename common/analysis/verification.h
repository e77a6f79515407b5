#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/identification.h"
#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Values of the unordered pairs of meshes: of one person, and of two. A pair is accepted at a
/// threshold if its value is at or below it.
struct VerificationScores {
  std::vector<double> genuine;   ///< Ascending.
  std::vector<double> impostor;  ///< Ascending.
  int64_t missing = 0;           ///< Pairs not measured.
  int64_t unknown = 0;           ///< Pairs left out: a person (or session) is not known.
  int64_t same_session = 0;      ///< Pairs left out under kOtherSessions.
};

/// @return as IdentifyPersons.
[[nodiscard]] absl::StatusOr<VerificationScores> CollectScores(const MetricMatrix& matrix,
                                                               const Identities& identities,
                                                               Gallery gallery);

/// What a threshold does.
struct ErrorRates {
  double threshold = 0;
  double false_accept_rate = 0;  ///< Share of impostor pairs at or below it (FAR, FMR).
  double false_reject_rate = 0;  ///< Share of genuine pairs above it (FRR, FNMR).
};

/// FAR and FRR at a threshold; NaN for a class without pairs.
[[nodiscard]] ErrorRates RatesAt(const VerificationScores& scores, double threshold);

/// The largest threshold among the values whose FAR is at most `false_accept_rate`; -infinity (all
/// are rejected) if there is none.
[[nodiscard]] ErrorRates RatesAtFalseAccepts(const VerificationScores& scores,
                                             double false_accept_rate);

struct Verification {
  /// The corners of the staircase of RatesAt over all values, ascending: first a threshold of
  /// -infinity (FAR 0, FRR 1), last one with FAR 1, FRR 0. Runs in which only one of the rates
  /// changes have their last point, so that there are at most 2 genuine pairs + 2.
  std::vector<ErrorRates> roc;
  /// Where FAR equals FRR on the polyline of `roc`.
  double equal_error_rate = 0;
  /// The value at which FAR and FRR differ least (of several, the lowest).
  ErrorRates nearest_equal;
  /// |mean genuine - mean impostor| / sqrt((variance genuine + variance impostor) / 2), variances
  /// divided by n; infinite if both are zero and the means differ, NaN if they do not.
  double d_prime = 0;
  /// Probability that a genuine pair has the lower value of the two, ties half: area under the ROC.
  double area = 0;
};

/// @return kFailedPrecondition if there is no genuine or no impostor pair.
/// Source: Mansfield, Wayman 2002 (rates); Daugman 2000 (d').
[[nodiscard]] absl::StatusOr<Verification> VerifyPairs(const VerificationScores& scores);

/// How often the values fall into equal bins over the range of both classes; bin i is
/// [first + i width, first + (i+1) width), the last one closed.
struct ScoreHistogram {
  double first = 0;
  double width = 0;
  std::vector<int64_t> genuine;
  std::vector<int64_t> impostor;
};
/// @param bins  >= 1. Without values, or if all are equal: one bin of width 0.
[[nodiscard]] ScoreHistogram HistogramOf(const VerificationScores& scores, int bins);

}  // namespace cohort
