#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/analysis_input.h"
#include "common/analysis/clustering.h"
#include "common/analysis/group_distances.h"
#include "common/analysis/identification.h"
#include "common/analysis/metric_matrix.h"
#include "common/analysis/ordination.h"
#include "common/analysis/permanova.h"
#include "common/analysis/verification.h"
#include "common/base/executor.h"
#include "common/report/statistics_csv.h"

namespace cohort {

struct AnalysisOptions {
  int neighbours = 3;  ///< Of each mesh, 1 or more; cut at N - 1.
  Linkage linkage = Linkage::kAverage;
  int clusters = 0;                      ///< To cut the tree into; 0: do not.
  int axes = 10;                         ///< Of the ordination.
  std::string by = {};                   ///< Label column of the groups; empty: no groups.
  std::string person = "person";         ///< Label column; if no mesh has it, nobody is identified.
  std::string session = "session";       ///< The same, for leave-one-session-out.
  std::optional<double> threshold = {};  ///< To tell the error rates of.
  int64_t permutations = 9999;
  uint64_t seed = 1;

  /// @return kInvalidArgument naming the option.
  [[nodiscard]] absl::Status Validate() const;
};

/// Persons sought among all other meshes, or among those of other sessions.
struct PersonAnalysis {
  Identification identification;
  VerificationScores scores;
  std::optional<Verification> verification;  ///< Empty without pairs of both kinds.
};

/// All statistics of one matrix. What needs every pair is of the meshes in `complete`.
struct Analysis {
  std::vector<std::vector<Neighbour>> neighbours;
  MetricMatrix complete;
  std::vector<std::string> incomplete;  ///< Meshes that are not in it, as pairs of theirs miss.
  Dendrogram dendrogram;
  std::vector<int64_t> clusters;  ///< Of the meshes in `complete`; empty: not asked for.
  Ordination ordination;
  OutlierTable outliers;
  std::optional<GroupDistances> groups;
  std::optional<Permanova> permanova;
  std::vector<std::string> persons;  ///< One per row; empty: not known.
  std::optional<PersonAnalysis> identification;
  std::optional<PersonAnalysis> other_sessions;
  std::vector<std::string> notes;  ///< What was left out, and why; one line each.
};

/// @return kInvalidArgument naming option, column or mesh: a column `by` that no mesh has or that
///         has one group; a matrix of no distances; under three meshes left with all their pairs.
[[nodiscard]] absl::StatusOr<Analysis> AnalyzeMatrix(const AnalysisInput& input,
                                                     const AnalysisOptions& options,
                                                     Executor& executor);

}  // namespace cohort
