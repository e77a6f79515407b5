#include "common/analysis/permanova.h"

#include <map>
#include <numeric>
#include <string_view>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/analysis/permutations.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr int64_t kMostPermutations = 10'000'000;

/// Places of each group: [g] lists rows.
using Places = std::vector<std::vector<int32_t>>;

Places PlacesOf(std::span<const std::string> groups) {
  std::map<std::string_view, std::vector<int32_t>> by_name;
  for (size_t i = 0; i < groups.size(); ++i) {
    by_name[groups[i]].push_back(static_cast<int32_t>(i));
  }
  Places places;
  for (auto& [name, rows] : by_name) {
    places.push_back(std::move(rows));
  }
  return places;
}

/// Sum over the groups of the squares of their pairs, divided by their size; place i is held by the
/// mesh order[i].
double SumWithin(const RowMajorMatrix& squares,
                 const Places& places,
                 const std::vector<int32_t>& order) {
  double total = 0;
  for (const std::vector<int32_t>& group : places) {
    double sum = 0;
    for (size_t i = 1; i < group.size(); ++i) {
      const double* row = squares.row(order[static_cast<size_t>(group[i])]).data();
      for (size_t j = 0; j < i; ++j) {
        sum += row[order[static_cast<size_t>(group[j])]];
      }
    }
    total += sum / static_cast<double>(group.size());
  }
  return total;
}

absl::Status RequireGroups(const Places& places, size_t meshes, std::string_view first) {
  if (places.size() < 2) {
    return absl::InvalidArgumentError(
        meshes == 0 ? "no mesh has a group"
                    : absl::StrCat("all meshes are of one group, ", std::string(first)));
  }
  if (places.size() == meshes) {
    return absl::InvalidArgumentError(
        absl::StrCat("each of the ", meshes, " meshes is a group of its own"));
  }
  return absl::OkStatus();
}

double PseudoF(const Permanova& table, double residual) {
  const double groups = table.sum_of_squares_total - residual;
  return (groups / static_cast<double>(table.groups - 1)) /
         (residual / static_cast<double>(table.meshes - table.groups));
}

}  // namespace

absl::Status PermanovaOptions::Validate() const {
  if (permutations < 1 || permutations > kMostPermutations) {
    return absl::InvalidArgumentError(
        absl::StrCat("permutations: ", permutations, ", expected 1 to ", kMostPermutations));
  }
  return absl::OkStatus();
}

absl::StatusOr<Permanova> TestGroups(const MetricMatrix& distances,
                                     std::span<const std::string> groups,
                                     const PermanovaOptions& options,
                                     Executor& executor) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (std::ssize(groups) != distances.values.rows()) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", groups.size(), " groups for ",
                                                   distances.values.rows(), " meshes"));
  }
  std::vector<int64_t> labelled;
  std::vector<std::string> known;
  for (size_t i = 0; i < groups.size(); ++i) {
    if (!groups[i].empty()) {
      labelled.push_back(static_cast<int64_t>(i));
      known.push_back(groups[i]);
    }
  }
  const Places places = PlacesOf(known);
  COHORT_RETURN_IF_ERROR(
      RequireGroups(places, known.size(), known.empty() ? std::string_view() : known.front()));
  const MetricMatrix part = PartOf(distances, labelled);
  COHORT_RETURN_IF_ERROR(RequireDissimilarities(part, 3));
  COHORT_RETURN_IF_ERROR(RequireComplete(part));

  const RowMajorMatrix squares = part.values.cwiseAbs2();
  std::vector<int32_t> order(known.size());
  std::iota(order.begin(), order.end(), 0);
  Permanova table;
  table.meshes = std::ssize(known);
  table.groups = std::ssize(places);
  table.sum_of_squares_total = SumWithin(squares, {order}, order);
  if (table.sum_of_squares_total == 0) {
    return absl::FailedPreconditionError("all distances are zero");
  }
  table.sum_of_squares_residual = SumWithin(squares, places, order);
  table.sum_of_squares_groups = table.sum_of_squares_total - table.sum_of_squares_residual;
  table.r_squared = table.sum_of_squares_groups / table.sum_of_squares_total;
  table.f = PseudoF(table, table.sum_of_squares_residual);
  table.permutations = options.permutations;
  // F grows as the residual falls, so the sums tell; the tolerance is a share of them.
  const double largest =
      table.sum_of_squares_residual + kPermutationTolerance * table.sum_of_squares_total;
  table.as_extreme = CountExtremeOrders(
      table.meshes, options.permutations, options.seed,
      [&](const std::vector<int32_t>& shuffled) {
        return SumWithin(squares, places, shuffled) <= largest;
      },
      executor);
  table.p = static_cast<double>(1 + table.as_extreme) / static_cast<double>(1 + table.permutations);
  return table;
}

}  // namespace cohort
