#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Who is on each mesh of a matrix and when; "" for unknown. Meshes of unknown person take no part.
struct Identities {
  std::vector<std::string> persons;   ///< One per row.
  std::vector<std::string> sessions;  ///< One per row, or none at all: no sessions.
};

/// What a mesh (the probe) is compared with (the gallery). kOtherSessions is leave-one-session-out:
/// the meshes of each session are sought among those of all other ones; those of unknown session
/// take no part.
enum class Gallery { kAllOthers, kOtherSessions };

/// One mesh sought among the others.
struct ProbeSearch {
  int64_t probe = 0;          ///< Row.
  int64_t mate = -1;          ///< Nearest mesh of the same person; -1: none (measured).
  double mate_value = 0;      ///< Its value; NaN without a mate.
  int64_t impostor = -1;      ///< Nearest mesh of another person; -1: none.
  double impostor_value = 0;  ///< NaN without one.
  int64_t rank = 0;           ///< 1 + meshes of others not farther than the mate; 0: no mate.
};

/// Closed-set identification: is the right person among the k nearest meshes?
struct Identification {
  std::vector<ProbeSearch> searches;  ///< One per mesh of known person (and session), ascending.
  int64_t with_mate = 0;              ///< Searches that can succeed; the base of the shares.
  /// Cumulative match characteristic: [k-1] is the share of searches with a mate of rank <= k. Up
  /// to the largest gallery; empty if no mesh has a mate.
  std::vector<double> match_share;

  /// match_share of rank k >= 1; 1 beyond its end.
  [[nodiscard]] double ShareAtRank(int64_t k) const;
};

/// Ties count against the match: of equal values, the other person's comes first, so that the order
/// of the meshes does not matter. Missing values are never found. O(N^2).
/// @param matrix  undirected, small = similar.
/// @return as RequireDissimilarities (2 meshes); kInvalidArgument if the labels are not one per
/// row,
///         no person is known, kOtherSessions without two known sessions.
[[nodiscard]] absl::StatusOr<Identification> IdentifyPersons(const MetricMatrix& matrix,
                                                             const Identities& identities,
                                                             Gallery gallery);

}  // namespace cohort
