#include "common/report/statistics_csv.h"

#include <algorithm>
#include <cassert>

#include "common/analysis/outliers.h"
#include "common/report/csv.h"
#include "common/report/decimal.h"

namespace cohort {
namespace {

const std::string kMissing = "NA";

using Fields = std::vector<std::string>;

std::string Text(int64_t value) {
  return std::to_string(value);
}
std::string Text(double value) {
  return ShortestDecimal(value);
}

const std::string& LabelOf(std::span<const std::string> labels, int64_t row) {
  return row < 0 ? kMissing : labels[static_cast<size_t>(row)];
}

Fields GroupRow(const std::string& kind,
                const std::string& first,
                const std::string& second,
                const PairSummary& values) {
  return {kind,
          first,
          second,
          Text(values.pairs),
          Text(values.missing),
          Text(values.mean),
          Text(values.deviation),
          Text(values.least),
          Text(values.median),
          Text(values.largest)};
}

}  // namespace

std::string MergesCsv(const Dendrogram& dendrogram) {
  std::string csv = CsvRow(Fields{"left", "right", "height", "size"});
  for (const Merge& merge : dendrogram.merges) {
    csv +=
        CsvRow(Fields{Text(merge.left), Text(merge.right), Text(merge.height), Text(merge.size)});
  }
  return csv;
}

std::string ClustersCsv(std::span<const std::string> labels,
                        const Dendrogram& dendrogram,
                        std::span<const int64_t> clusters) {
  assert(labels.size() == dendrogram.leaf_order.size());
  assert(clusters.empty() || clusters.size() == labels.size());
  std::vector<int64_t> position(labels.size());
  for (size_t place = 0; place < labels.size(); ++place) {
    position[static_cast<size_t>(dendrogram.leaf_order[place])] = static_cast<int64_t>(place + 1);
  }
  Fields fields = {"mesh", "position"};
  if (!clusters.empty()) {
    fields.emplace_back("cluster");
  }
  std::string csv = CsvRow(fields);
  for (size_t i = 0; i < labels.size(); ++i) {
    fields = {labels[i], Text(position[i])};
    if (!clusters.empty()) {
      fields.push_back(Text(clusters[i] + 1));
    }
    csv += CsvRow(fields);
  }
  return csv;
}

std::string PcoaCsv(std::span<const std::string> labels, const Ordination& ordination) {
  Fields fields = {"mesh"};
  for (Eigen::Index axis = 0; axis < ordination.coordinates.cols(); ++axis) {
    std::string name = "axis";
    name += std::to_string(axis + 1);
    fields.push_back(name);
  }
  std::string csv = CsvRow(fields);
  for (size_t i = 0; i < labels.size(); ++i) {
    fields = {labels[i]};
    for (const double coordinate : ordination.coordinates.row(static_cast<Eigen::Index>(i))) {
      fields.push_back(Text(coordinate));
    }
    csv += CsvRow(fields);
  }
  return csv;
}

std::string EigenvaluesCsv(const Ordination& ordination) {
  std::string csv = CsvRow(Fields{"axis", "eigenvalue", "explained"});
  for (size_t i = 0; i < ordination.eigenvalues.size(); ++i) {
    csv +=
        CsvRow(Fields{Text(static_cast<int64_t>(i + 1)), Text(ordination.eigenvalues[i]),
                      i < ordination.explained.size() ? Text(ordination.explained[i]) : kMissing});
  }
  return csv;
}

std::string PermanovaCsv(const Permanova& table, const std::string& term) {
  const double residual_share = table.sum_of_squares_residual / table.sum_of_squares_total;
  return CsvRow(Fields{"term", "df", "sum_of_squares", "r_squared", "f", "p"}) +
         CsvRow(Fields{term, Text(table.groups - 1), Text(table.sum_of_squares_groups),
                       Text(table.r_squared), Text(table.f), Text(table.p)}) +
         CsvRow(Fields{"residual", Text(table.meshes - table.groups),
                       Text(table.sum_of_squares_residual), Text(residual_share), kMissing,
                       kMissing}) +
         CsvRow(Fields{"total", Text(table.meshes - 1), Text(table.sum_of_squares_total), "1",
                       kMissing, kMissing});
}

std::string GroupsCsv(const GroupDistances& table) {
  Fields header = {"kind", "group", "other_group", "pairs", "missing"};
  for (const char* name : {"mean", "sd", "min", "median", "max"}) {
    header.emplace_back(name);
  }
  std::string csv = CsvRow(header);
  csv += CsvRow(GroupRow("within", kMissing, kMissing, table.within));
  csv += CsvRow(GroupRow("between", kMissing, kMissing, table.between));
  for (const GroupPairs& pairs : table.pairs) {
    csv += CsvRow(GroupRow(pairs.first == pairs.second ? "within" : "between", pairs.first,
                           pairs.second, pairs.values));
  }
  return csv;
}

bool OutlierTable::IsOutlier(size_t row) const {
  return mean_distance_z[row] > kOutlierZ || residual_z[row] > kOutlierZ;
}

std::string OutliersCsv(std::span<const std::string> labels, const OutlierTable& table) {
  Fields header = {"mesh", "mean_distance", "mean_distance_z", "residual", "residual_z"};
  header.emplace_back("outlier");
  std::string csv = CsvRow(header);
  for (size_t i = 0; i < labels.size(); ++i) {
    csv += CsvRow(Fields{labels[i], Text(table.mean_distances[i]), Text(table.mean_distance_z[i]),
                         Text(table.residuals[i]), Text(table.residual_z[i]),
                         table.IsOutlier(i) ? "TRUE" : "FALSE"});
  }
  return csv;
}

std::string IdentificationCsv(std::span<const std::string> labels,
                              std::span<const std::string> persons,
                              const Identification& identification) {
  Fields header = {"mesh", "person", "rank", "mate", "mate_value"};
  for (const char* name : {"nearest_other", "nearest_other_person", "nearest_other_value"}) {
    header.emplace_back(name);
  }
  std::string csv = CsvRow(header);
  for (const ProbeSearch& search : identification.searches) {
    csv +=
        CsvRow(Fields{LabelOf(labels, search.probe), LabelOf(persons, search.probe),
                      search.rank > 0 ? Text(search.rank) : kMissing, LabelOf(labels, search.mate),
                      Text(search.mate_value), LabelOf(labels, search.impostor),
                      LabelOf(persons, search.impostor), Text(search.impostor_value)});
  }
  return csv;
}

std::string CmcCsv(const Identification& identification,
                   const std::optional<Identification>& other_sessions) {
  const bool has_sessions = other_sessions && !other_sessions->match_share.empty();
  Fields fields = {"rank", "share"};
  if (has_sessions) {
    fields.emplace_back("share_other_sessions");
  }
  std::string csv = CsvRow(fields);
  for (int64_t rank = 1; rank <= std::ssize(identification.match_share); ++rank) {
    fields = {Text(rank), Text(identification.ShareAtRank(rank))};
    if (has_sessions) {
      fields.push_back(Text(other_sessions->ShareAtRank(rank)));
    }
    csv += CsvRow(fields);
  }
  return csv;
}

std::string RocCsv(const Verification& verification) {
  std::string csv = CsvRow(Fields{"threshold", "false_accept_rate", "false_reject_rate"});
  for (const ErrorRates& point : verification.roc) {
    csv += CsvRow(Fields{Text(point.threshold), Text(point.false_accept_rate),
                         Text(point.false_reject_rate)});
  }
  return csv;
}

std::string ScoresText(std::span<const double> scores) {
  std::string text;
  for (const double score : scores) {
    text += ShortestDecimal(score);
    text += '\n';
  }
  return text;
}

}  // namespace cohort
