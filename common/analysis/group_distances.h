#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/metric_matrix.h"

namespace cohort {

/// Values of some pairs; NaN where there are none (deviation: where there is one).
struct PairSummary {
  int64_t pairs = 0;    ///< Measured.
  int64_t missing = 0;  ///< Not measured, left out of all else.
  double mean = 0;
  double deviation = 0;  ///< Standard deviation, n - 1.
  double least = 0;
  double median = 0;  ///< Mean of the middle two.
  double largest = 0;
};

/// The unordered pairs of two groups; of one group with itself: of its meshes.
struct GroupPairs {
  std::string first;
  std::string second;
  PairSummary values;
};

struct GroupDistances {
  std::vector<std::string> groups;  ///< Sorted bytewise.
  std::vector<int64_t> sizes;       ///< Meshes of each.
  std::vector<GroupPairs> pairs;    ///< (0,0), (0,1), ... (0,g-1), (1,1), ...
  PairSummary within;               ///< All pairs of one group.
  PairSummary between;              ///< All pairs of two.
};

/// How near the meshes of each group are to each other and to those of every other group. Meshes
/// without a group ("") are left out. O(N^2 log N).
/// @param matrix  undirected.
/// @param groups  one per row.
/// @return as RequireSymmetric (2 meshes); kInvalidArgument if the groups are not one per row or
///         under two are known.
[[nodiscard]] absl::StatusOr<GroupDistances> SummarizeGroups(const MetricMatrix& matrix,
                                                             std::span<const std::string> groups);

}  // namespace cohort
