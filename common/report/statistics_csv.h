#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/analysis/clustering.h"
#include "common/analysis/group_distances.h"
#include "common/analysis/identification.h"
#include "common/analysis/ordination.h"
#include "common/analysis/permanova.h"
#include "common/analysis/verification.h"

namespace cohort {

// Tables of the statistics of a matrix, in the form of csv.h; `labels` are those of the matrix.

/// "left,right,height,size": one merge a row, clusters numbered as in Merge.
[[nodiscard]] std::string MergesCsv(const Dendrogram& dendrogram);

/// "mesh,position": place among the leaves, from 1; with clusters (CutDendrogram) also "cluster",
/// from 1.
[[nodiscard]] std::string ClustersCsv(std::span<const std::string> labels,
                                      const Dendrogram& dendrogram,
                                      std::span<const int64_t> clusters);

/// "mesh,axis1,axis2,...".
[[nodiscard]] std::string PcoaCsv(std::span<const std::string> labels,
                                  const Ordination& ordination);
/// "axis,eigenvalue,explained" of all eigenvalues; NA for shares of axes that are not in pcoa.csv.
[[nodiscard]] std::string EigenvaluesCsv(const Ordination& ordination);

/// "term,df,sum_of_squares,r_squared,f,p": the label column, residual, total.
[[nodiscard]] std::string PermanovaCsv(const Permanova& table, const std::string& term);

/// "kind,group,other_group,pairs,missing,mean,sd,min,median,max": all pairs within a group and all
/// between two (groups NA), then each pair of groups.
[[nodiscard]] std::string GroupsCsv(const GroupDistances& table);

/// A mesh is an outlier if one of its robust z is above kOutlierZ.
struct OutlierTable {
  std::vector<double> mean_distances;
  std::vector<double> mean_distance_z;
  std::vector<double> residuals;  ///< Of the alignment; NaN: not known.
  std::vector<double> residual_z;

  [[nodiscard]] bool IsOutlier(size_t row) const;
};
/// "mesh,mean_distance,mean_distance_z,residual,residual_z,outlier".
[[nodiscard]] std::string OutliersCsv(std::span<const std::string> labels,
                                      const OutlierTable& table);

/// One search a row: "mesh,person,rank,mate,mate_value,nearest_other,nearest_other_person,
/// nearest_other_value"; rank NA without a mate.
[[nodiscard]] std::string IdentificationCsv(std::span<const std::string> labels,
                                            std::span<const std::string> persons,
                                            const Identification& identification);
/// "rank,share"; with leave-one-session-out also "share_other_sessions".
[[nodiscard]] std::string CmcCsv(const Identification& identification,
                                 const std::optional<Identification>& other_sessions);
/// "threshold,false_accept_rate,false_reject_rate".
[[nodiscard]] std::string RocCsv(const Verification& verification);

/// One value a line (LF), shortest decimals: what tools for biometrics read.
[[nodiscard]] std::string ScoresText(std::span<const double> scores);

}  // namespace cohort
