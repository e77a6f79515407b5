#include "common/analysis/group_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

PairSummary Summarize(std::vector<double> values, int64_t missing) {
  PairSummary summary{.pairs = std::ssize(values),
                      .missing = missing,
                      .mean = kUnknown,
                      .deviation = kUnknown,
                      .least = kUnknown,
                      .median = kUnknown,
                      .largest = kUnknown};
  if (values.empty()) {
    return summary;
  }
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  summary.mean = sum / count;
  double squares = 0;
  for (const double value : values) {
    squares += (value - summary.mean) * (value - summary.mean);
  }
  if (values.size() > 1) {
    summary.deviation = std::sqrt(squares / (count - 1));
  }
  summary.least = values.front();
  summary.largest = values.back();
  const size_t middle = values.size() / 2;
  summary.median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return summary;
}

/// Values of some pairs, until all are there.
struct Collected {
  std::vector<double> values;
  int64_t missing = 0;

  void Add(double value) {
    if (std::isnan(value)) {
      ++missing;
    } else {
      values.push_back(value);
    }
  }
};

/// Values by pair of groups; both orders of a pair are the same.
struct CollectedGroups {
  std::map<std::pair<std::string, std::string>, Collected> pairs;
  Collected within;
  Collected between;
};

/// @param sizes  the groups.
CollectedGroups CollectGroups(const MetricMatrix& matrix,
                              std::span<const std::string> groups,
                              const std::map<std::string, int64_t>& sizes) {
  CollectedGroups collected;
  for (auto first = sizes.begin(); first != sizes.end(); ++first) {
    for (auto second = first; second != sizes.end(); ++second) {
      collected.pairs[{first->first, second->first}];
    }
  }
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    for (Eigen::Index column = 0; column < row; ++column) {
      const std::string& a = groups[static_cast<size_t>(row)];
      const std::string& b = groups[static_cast<size_t>(column)];
      if (!a.empty() && !b.empty()) {
        const double value = matrix.values(row, column);
        collected.pairs.find(std::minmax(a, b))->second.Add(value);
        (a == b ? collected.within : collected.between).Add(value);
      }
    }
  }
  return collected;
}

}  // namespace

absl::StatusOr<GroupDistances> SummarizeGroups(const MetricMatrix& matrix,
                                               std::span<const std::string> groups) {
  COHORT_RETURN_IF_ERROR(RequireSymmetric(matrix, 2));
  if (std::ssize(groups) != matrix.values.rows()) {
    return absl::InvalidArgumentError(
        absl::StrCat("there are ", groups.size(), " groups for ", matrix.values.rows(), " meshes"));
  }
  std::map<std::string, int64_t> sizes;
  for (const std::string& group : groups) {
    if (!group.empty()) {
      ++sizes[group];
    }
  }
  if (sizes.size() < 2) {
    return absl::InvalidArgumentError(
        sizes.empty() ? "no mesh has a group"
                      : absl::StrCat("all meshes are of one group, ", sizes.begin()->first));
  }
  CollectedGroups collected = CollectGroups(matrix, groups, sizes);
  GroupDistances table;
  for (const auto& [group, size] : sizes) {
    table.groups.push_back(group);
    table.sizes.push_back(size);
  }
  for (auto& [names, pairs] : collected.pairs) {
    table.pairs.push_back(
        {names.first, names.second, Summarize(std::move(pairs.values), pairs.missing)});
  }
  table.within = Summarize(std::move(collected.within.values), collected.within.missing);
  table.between = Summarize(std::move(collected.between.values), collected.between.missing);
  return table;
}

}  // namespace cohort
