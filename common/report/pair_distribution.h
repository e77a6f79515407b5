#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/analysis/metric_matrix.h"
#include "common/base/scratch.h"
#include "common/jobs/job_spec.h"

namespace cohort {

/// Values of the pairs of a matrix by what is known about their persons; each list ascending.
struct PairValues {
  bool by_person = false;      ///< Two classes are told apart; otherwise all are in `different`.
  ScratchVector<double> same;  ///< Both meshes of one person.
  ScratchVector<double> different;  ///< Of two people; all pairs without persons.
  int64_t missing = 0;              ///< NaN.
  int64_t unknown = 0;              ///< Left out: a person is not known.
};

/// @param symmetrization  kDirected: both directions of a pair count, otherwise the upper one.
/// @param persons  one per row, "" for unknown, or none.
[[nodiscard]] PairValues CollectPairs(const MatrixView& matrix,
                                      Symmetrization symmetrization,
                                      std::span<const std::string> persons);

/// Median of ascending values (mean of the middle two); 0 if there are none.
[[nodiscard]] double MedianOfSorted(std::span<const double> sorted);

/// Bins of equal width; bin i is [first + i width, first + (i + 1) width).
struct Bins {
  double first = 0;
  double width = 1;
  int count = 1;
  int64_t beyond = 0;  ///< Values beyond the last bin (FarFence of each class), counted in it.
};

/// Bins for the values of all classes together: width near 2 IQR / n^(1/3), a nice number, such
/// that there are about 10 to 60. Source: Freedman, Diaconis 1981.
[[nodiscard]] Bins ChooseBins(const PairValues& pairs);

/// Values per bin; a value beyond the ends counts in the outermost bin.
[[nodiscard]] std::vector<int64_t> CountInBins(std::span<const double> values, const Bins& bins);

}  // namespace cohort
