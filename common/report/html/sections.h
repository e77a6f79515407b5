#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "common/analysis/clustering.h"
#include "common/report/html/mesh_flags.h"
#include "common/report/html/report_html.h"
#include "common/report/plots/group_style.h"

namespace cohort {

// The parts of the report; each is a <section>, or empty if this job has nothing of the kind.

/// More meshes than this get no tree and no rates of errors: nobody could look at the one, and both
/// need the matrix several times over.
inline constexpr int64_t kMostAnalyzed = 5000;

/// What several parts need.
struct ReportAnalysis {
  std::vector<MeshFlags> flags;    ///< One per mesh of the job.
  MetricMatrix undirected;         ///< The matrix with one value a pair; empty: too many meshes.
  std::vector<int64_t> rows;       ///< Of the matrix without missing cells, ascending.
  MetricMatrix complete;           ///< `undirected` of `rows`.
  std::optional<Dendrogram> tree;  ///< Of `complete`.
  std::string no_tree;             ///< Why there is none.
};
[[nodiscard]] ReportAnalysis Analyze(const ReportInput& input);

/// The labels of the meshes by which groups can be told apart: at least two values, one that occurs
/// twice, and (but for persons) no more than 28; "person" first. One value per row of the matrix.
[[nodiscard]] std::vector<Groups> GroupsOfRows(const ReportInput& input);

[[nodiscard]] std::string SummarySection(const ReportInput& input, const ReportAnalysis& analysis);
[[nodiscard]] std::string ParametersSection(const ReportInput& input);
[[nodiscard]] std::string HealthSection(const ReportInput& input, const ReportAnalysis& analysis);
[[nodiscard]] std::string MatrixSection(const ReportInput& input, const ReportAnalysis& analysis);
[[nodiscard]] std::string NeighboursSection(const ReportInput& input);
[[nodiscard]] std::string DendrogramSection(const ReportInput& input,
                                            const ReportAnalysis& analysis);
[[nodiscard]] std::string OrdinationSection(const ReportInput& input,
                                            const ReportAnalysis& analysis);
[[nodiscard]] std::string DistributionSection(const ReportInput& input);
[[nodiscard]] std::string IdentificationSection(const ReportInput& input,
                                                const ReportAnalysis& analysis);
[[nodiscard]] absl::StatusOr<std::string> ShapeSection(const ReportInput& input,
                                                       Executor& executor);
[[nodiscard]] std::string RegistrationSection(const ReportInput& input,
                                              const ReportAnalysis& analysis);

/// Rules that give each thumbnail, number i in the class "t<i>", once for all of its places.
[[nodiscard]] std::string ThumbnailStyle(const ReportInput& input);

}  // namespace cohort
