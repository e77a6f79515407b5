#include "client/analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <absl/strings/str_cat.h>

#include "client/analysis_meshes.h"
#include "common/analysis/distances.h"
#include "common/analysis/outliers.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// A number of an option that is out of its range.
absl::Status OutOfRange(const std::string& option, int64_t value, const std::string& expected) {
  return absl::InvalidArgumentError(absl::StrCat(option, " ", value, ": expected ", expected));
}

absl::Status In(const std::string& place, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(place, ": ", std::string(status.message())));
}

/// Splits off the meshes that some pair of theirs is missing of.
absl::Status TakeComplete(const AnalysisInput& input, Analysis& analysis) {
  const std::vector<int64_t> kept = CompleteMeshes(input.matrix);
  const std::set<int64_t> has_all(kept.begin(), kept.end());
  for (int64_t row = 0; row < input.matrix.values.rows(); ++row) {
    if (!has_all.contains(row)) {
      analysis.incomplete.push_back(input.matrix.labels[static_cast<size_t>(row)]);
    }
  }
  if (kept.size() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(input.source, ": ", kept.size(),
                     " meshes have values with all others, at least 3 are "
                     "needed; pairs are missing of ",
                     SomeOf(analysis.incomplete)));
  }
  analysis.complete = PartOf(input.matrix, kept);
  if (!analysis.incomplete.empty()) {
    analysis.notes.push_back(
        absl::StrCat("clusters, pcoa and permanova are without ", SomeOf(analysis.incomplete),
                     analysis.incomplete.size() == 1 ? ", which has missing pairs"
                                                     : ", which have missing pairs"));
  }
  return absl::OkStatus();
}

OutlierTable FindOutliers(const AnalysisInput& input) {
  OutlierTable table;
  table.mean_distances = MeanDistances(input.matrix);
  table.mean_distance_z = RobustZ(table.mean_distances);
  for (const std::string& mesh : input.matrix.labels) {
    const auto residual = input.residuals.find(mesh);
    table.residuals.push_back(residual == input.residuals.end()
                                  ? std::numeric_limits<double>::quiet_NaN()
                                  : residual->second);
  }
  table.residual_z = RobustZ(table.residuals);
  return table;
}

/// The groups of the meshes in `part`, which are some of those in `all`, in their order.
std::vector<std::string> GroupsOf(const MetricMatrix& part,
                                  const MetricMatrix& all,
                                  const std::vector<std::string>& groups) {
  std::vector<std::string> some;
  size_t row = 0;
  for (const std::string& mesh : part.labels) {
    while (all.labels[row] != mesh) {
      ++row;
    }
    some.push_back(groups[row]);
  }
  return some;
}

absl::Status CompareGroups(const AnalysisInput& input,
                           const AnalysisOptions& options,
                           Executor& executor,
                           Analysis& analysis) {
  if (options.by.empty()) {
    return absl::OkStatus();
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<std::string> groups, LabelColumn(input, options.by));
  const std::string place = absl::StrCat(input.source, ": groups by ", options.by);
  absl::StatusOr<GroupDistances> distances = SummarizeGroups(input.matrix, groups);
  if (!distances.ok()) {
    return In(place, distances.status());
  }
  analysis.groups = *std::move(distances);
  const absl::StatusOr<Permanova> permanova =
      TestGroups(analysis.complete, GroupsOf(analysis.complete, input.matrix, groups),
                 {.permutations = options.permutations, .seed = options.seed}, executor);
  if (!permanova.ok()) {
    return In(place, permanova.status());
  }
  analysis.permanova = *permanova;
  const auto unknown = std::count(groups.begin(), groups.end(), "");
  if (unknown > 0) {
    analysis.notes.push_back(
        absl::StrCat(unknown, " of ", groups.size(), " meshes have no ", options.by));
  }
  return absl::OkStatus();
}

absl::StatusOr<PersonAnalysis> AnalyzePersons(const MetricMatrix& matrix,
                                              const Identities& identities,
                                              Gallery gallery) {
  PersonAnalysis persons;
  COHORT_ASSIGN_OR_RETURN(persons.identification, IdentifyPersons(matrix, identities, gallery));
  COHORT_ASSIGN_OR_RETURN(persons.scores, CollectScores(matrix, identities, gallery));
  if (absl::StatusOr<Verification> verification = VerifyPairs(persons.scores); verification.ok()) {
    persons.verification = *std::move(verification);
  }
  return persons;
}

/// Nobody asked for it by name, so that labels that do not serve are a note, no error.
absl::Status Identify(const AnalysisInput& input,
                      const AnalysisOptions& options,
                      Analysis& analysis) {
  const bool asked = options.person != AnalysisOptions().person;
  const absl::StatusOr<std::vector<std::string>> persons = LabelColumn(input, options.person);
  if (!persons.ok()) {
    return asked || options.threshold ? persons.status() : absl::OkStatus();
  }
  Identities identities{.persons = *persons, .sessions = {}};
  absl::StatusOr<PersonAnalysis> all =
      AnalyzePersons(input.matrix, identities, Gallery::kAllOthers);
  if (!all.ok()) {
    if (asked || options.threshold) {
      return In(absl::StrCat(input.source, ": ", options.person), all.status());
    }
    analysis.notes.push_back(
        absl::StrCat("nobody is identified: ", std::string(all.status().message())));
    return absl::OkStatus();
  }
  if (all->identification.with_mate == 0) {
    analysis.notes.push_back("nobody is identified: no person has two meshes with a value");
    return absl::OkStatus();
  }
  analysis.persons = *persons;
  analysis.identification = *std::move(all);

  const bool session_asked = options.session != AnalysisOptions().session;
  const absl::StatusOr<std::vector<std::string>> sessions = LabelColumn(input, options.session);
  if (!sessions.ok()) {
    return session_asked ? sessions.status() : absl::OkStatus();
  }
  identities.sessions = *sessions;
  absl::StatusOr<PersonAnalysis> others =
      AnalyzePersons(input.matrix, identities, Gallery::kOtherSessions);
  if (others.ok() && others->identification.with_mate > 0) {
    analysis.other_sessions = *std::move(others);
  } else if (session_asked && !others.ok()) {
    return In(absl::StrCat(input.source, ": ", options.session), others.status());
  } else {
    analysis.notes.push_back(absl::StrCat("no session is left out: ",
                                          others.ok() ? "no person has meshes of two sessions"
                                                      : std::string(others.status().message())));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status AnalysisOptions::Validate() const {
  if (neighbours < 1) {
    return OutOfRange("--neighbours", neighbours, "1 or more");
  }
  if (clusters < 0) {
    return OutOfRange("--clusters", clusters, "1 or more, or 0 for none");
  }
  if (axes < 1) {
    return OutOfRange("--axes", axes, "1 or more");
  }
  if (threshold && !std::isfinite(*threshold)) {
    return absl::InvalidArgumentError("--threshold: expected a number");
  }
  return PermanovaOptions{.permutations = permutations, .seed = seed}.Validate();
}

absl::StatusOr<Analysis> AnalyzeMatrix(const AnalysisInput& input,
                                       const AnalysisOptions& options,
                                       Executor& executor) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (absl::Status usable = RequireDissimilarities(input.matrix, 3); !usable.ok()) {
    return In(input.source, usable);
  }
  Analysis analysis;
  COHORT_RETURN_IF_ERROR(TakeComplete(input, analysis));
  const auto complete = std::ssize(analysis.complete.labels);
  if (options.clusters > complete) {
    return OutOfRange("--clusters", options.clusters, absl::StrCat("at most ", complete));
  }
  // What takes little time and may find fault with the labels goes first.
  COHORT_RETURN_IF_ERROR(Identify(input, options, analysis));
  COHORT_RETURN_IF_ERROR(CompareGroups(input, options, executor, analysis));
  analysis.neighbours = NearestNeighbours(input.matrix, options.neighbours);
  COHORT_ASSIGN_OR_RETURN(analysis.dendrogram, ClusterMeshes(analysis.complete, options.linkage));
  if (options.clusters > 0) {
    analysis.clusters = CutDendrogram(analysis.dendrogram, options.clusters);
  }
  COHORT_ASSIGN_OR_RETURN(analysis.ordination, OrdinateMeshes(analysis.complete, options.axes));
  analysis.outliers = FindOutliers(input);
  return analysis;
}

}  // namespace cohort
