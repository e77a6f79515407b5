#include <map>
#include <set>

#include "common/analysis/distances.h"
#include "common/report/html/sections.h"
#include "common/report/job_meshes.h"

namespace cohort {
namespace {

constexpr size_t kMostGroups = 28;  // Styles of StyleOfGroup.
constexpr size_t kMostLabels = 4;   // Keys of labels that get a plot.

// Values of a label, one per row of the matrix; "" for unknown.
std::vector<std::string> ValuesOfRows(const ReportInput& input, const std::string& key) {
  std::vector<std::string> values;
  for (const JobMesh& mesh : input.meshes) {
    if (!mesh.rejection.empty()) continue;
    const auto label = mesh.mesh.labels.find(key);
    values.push_back(label == mesh.mesh.labels.end() ? "" : label->second);
  }
  return values;
}

// Persons may be many; of another label more values than styles (texts, measures) tell nothing.
bool TellsGroupsApart(const Groups& groups) {
  std::map<int, int> members;
  bool has_pair = false;
  for (const int group : groups.group_of) has_pair |= group >= 0 && ++members[group] == 2;
  const bool is_readable = groups.title == kPersonLabel || groups.names.size() <= kMostGroups;
  return groups.names.size() >= 2 && has_pair && is_readable;
}

}  // namespace

ReportAnalysis Analyze(const ReportInput& input) {
  ReportAnalysis analysis;
  analysis.flags = FindFlags(input);
  if (std::ssize(input.matrix.labels) > kMostAnalyzed) {
    analysis.no_tree = "Left out of this report for more than " + std::to_string(kMostAnalyzed) +
                       " meshes; dendrogram.newick beside it has the tree of up to " +
                       std::to_string(kMostClustered) + ".";
    return analysis;
  }
  analysis.undirected = {{input.matrix.labels.begin(), input.matrix.labels.end()},
                         input.matrix.values};
  if (input.description.sign == DistanceSign::kSigned) {
    analysis.no_tree = "Signed values are no distances: there is no clustering of them.";
    return analysis;
  }
  if (input.description.symmetrization == Symmetrization::kDirected) {
    analysis.undirected = Symmetrized(input.matrix, PairRule::kMean);
  }
  analysis.rows = CompleteMeshes(analysis.undirected);
  analysis.complete = PartOf(analysis.undirected, analysis.rows);
  absl::StatusOr<Dendrogram> tree = ClusterMeshes(analysis.complete, Linkage::kAverage);
  if (tree.ok()) {
    analysis.tree = *std::move(tree);
  } else {
    analysis.no_tree = "Left out: " + std::string(tree.status().message()) + ".";
  }
  return analysis;
}

std::vector<Groups> GroupsOfRows(const ReportInput& input) {
  std::set<std::string> keys;
  for (const JobMesh& mesh : input.meshes) {
    for (const auto& [key, value] : mesh.mesh.labels) keys.insert(key);
  }
  std::vector<Groups> found;
  const auto add = [&](const std::string& key) {
    Groups groups = MakeGroups(key, ValuesOfRows(input, key));
    if (found.size() < kMostLabels && TellsGroupsApart(groups)) found.push_back(std::move(groups));
  };
  const std::string person(kPersonLabel);
  if (keys.erase(person) > 0) add(person);
  for (const std::string& key : keys) add(key);
  return found;
}

}  // namespace cohort
