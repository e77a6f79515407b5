#include "common/analysis/agreement.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

absl::Status RequireSameMeshes(const MetricMatrix& a, const MetricMatrix& b) {
  if (a.labels != b.labels) {
    return absl::InvalidArgumentError(
        absl::StrCat("the matrices are not of the same meshes in the same order (", a.labels.size(),
                     " and ", b.labels.size(), " meshes)"));
  }
  return absl::OkStatus();
}

bool Has(const std::vector<Neighbour>& neighbours, int64_t column) {
  return std::any_of(neighbours.begin(), neighbours.end(),
                     [&](const Neighbour& neighbour) { return neighbour.column == column; });
}

RowAgreement CompareRow(const std::vector<Neighbour>& reference,
                        const std::vector<Neighbour>& other) {
  RowAgreement row;
  row.same_order = reference.size() == other.size();
  for (size_t rank = 0; rank < reference.size(); ++rank) {
    row.missed += Has(other, reference[rank].column) ? 0 : 1;
    row.same_order =
        row.same_order && rank < other.size() && other[rank].column == reference[rank].column;
  }
  if (!reference.empty()) {
    row.nearest_kept = Has(other, reference[0].column);
    row.same_nearest = !other.empty() && other[0].column == reference[0].column;
  }
  return row;
}

Closer CloserOf(double first, double second, double reference) {
  const double to_first = std::abs(first - reference);
  const double to_second = std::abs(second - reference);
  if (std::isnan(to_first) || std::isnan(to_second)) {
    return Closer::kMissing;
  }
  return to_first < to_second   ? Closer::kFirst
         : to_second < to_first ? Closer::kSecond
                                : Closer::kEqual;
}

}  // namespace

absl::StatusOr<NeighbourAgreement> CompareNeighbours(const MetricMatrix& reference,
                                                     const MetricMatrix& other,
                                                     int k) {
  COHORT_RETURN_IF_ERROR(RequireSameMeshes(reference, other));
  if (k < 1 || k >= reference.values.rows()) {
    return absl::InvalidArgumentError(absl::StrCat(k, " neighbours of ", reference.values.rows(),
                                                   " meshes: expected 1 or more, under the "
                                                   "number of meshes"));
  }
  const auto wanted = NearestNeighbours(reference, k);
  const auto found = NearestNeighbours(other, k);
  NeighbourAgreement agreement;
  agreement.missed.resize(static_cast<size_t>(k));
  for (size_t i = 0; i < wanted.size(); ++i) {
    const RowAgreement row = CompareRow(wanted[i], found[i]);
    agreement.correct += row.same_order ? 1 : 0;
    agreement.wrong_order += row.missed == 0 && !row.same_order ? 1 : 0;
    if (row.missed > 0) {
      ++agreement.missed[static_cast<size_t>(row.missed - 1)];
    }
    agreement.wanted += std::ssize(wanted[i]);
    agreement.kept += std::ssize(wanted[i]) - row.missed;
    agreement.same_nearest += row.same_nearest ? 1 : 0;
    agreement.nearest_kept += row.nearest_kept ? 1 : 0;
    agreement.rows.push_back(row);
  }
  return agreement;
}

absl::StatusOr<Closeness> CompareCloseness(const MetricMatrix& first,
                                           const MetricMatrix& second,
                                           const MetricMatrix& reference) {
  COHORT_RETURN_IF_ERROR(RequireSameMeshes(first, reference));
  COHORT_RETURN_IF_ERROR(RequireSameMeshes(second, reference));
  Closeness closeness;
  for (Eigen::Index row = 0; row < reference.values.rows(); ++row) {
    for (Eigen::Index column = 0; column < reference.values.cols(); ++column) {
      const Closer closer = CloserOf(first.values(row, column), second.values(row, column),
                                     reference.values(row, column));
      closeness.cells.push_back(closer);
      closeness.first += closer == Closer::kFirst ? 1 : 0;
      closeness.second += closer == Closer::kSecond ? 1 : 0;
      closeness.equal += closer == Closer::kEqual ? 1 : 0;
      closeness.missing += closer == Closer::kMissing ? 1 : 0;
    }
  }
  return closeness;
}

}  // namespace cohort
