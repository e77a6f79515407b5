#include "client/analysis_meshes.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/files.h"
#include "client/labels_csv.h"
#include "client/name_pattern.h"
#include "common/analysis/distances.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr size_t kNamed = 5;

std::set<std::string> NamesOf(const AnalysisInput& input) {
  return {input.matrix.labels.begin(), input.matrix.labels.end()};
}

/// Those of `names` that are not in `others`.
std::vector<std::string> Missing(const std::set<std::string>& names,
                                 const std::set<std::string>& others) {
  std::vector<std::string> missing;
  std::set_difference(names.begin(), names.end(), others.begin(), others.end(),
                      std::back_inserter(missing));
  return missing;
}

absl::Status RequireSameMeshes(const std::vector<AnalysisInput>& inputs) {
  const AnalysisInput& first = inputs.front();
  for (const AnalysisInput& other : inputs) {
    for (const auto& [here, there] : {std::pair(&first, &other), std::pair(&other, &first)}) {
      const std::vector<std::string> missing = Missing(NamesOf(*here), NamesOf(*there));
      if (!missing.empty()) {
        return absl::InvalidArgumentError(absl::StrCat(
            missing.size(), missing.size() == 1 ? " mesh of " : " meshes of ", here->source,
            missing.size() == 1 ? " is not in " : " are not in ", there->source, ": ",
            SomeOf(missing), "; --common takes those that all have"));
      }
    }
  }
  return absl::OkStatus();
}

/// Rows of `names`, in their order.
std::vector<int64_t> RowsOf(const MetricMatrix& matrix, const std::vector<std::string>& names) {
  std::map<std::string, int64_t> row_of;
  for (size_t row = 0; row < matrix.labels.size(); ++row) {
    row_of[matrix.labels[row]] = static_cast<int64_t>(row);
  }
  std::vector<int64_t> rows;
  rows.reserve(names.size());
  for (const std::string& name : names) {
    rows.push_back(row_of.at(name));
  }
  return rows;
}

}  // namespace

std::string SomeOf(const std::vector<std::string>& names) {
  const std::vector<std::string> shown(
      names.begin(), names.begin() + std::min(std::ssize(names), std::ptrdiff_t{kNamed}));
  return absl::StrCat(
      absl::StrJoin(shown, ", "),
      names.size() > kNamed ? absl::StrCat(" and ", names.size() - kNamed, " more") : "");
}

absl::Status ReplaceLabels(const std::string& labels_file, AnalysisInput& input) {
  COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(labels_file));
  COHORT_ASSIGN_OR_RETURN(const Labels labels, ParseLabels(text, labels_file));
  const std::set<std::string> meshes = NamesOf(input);
  int64_t labelled = 0;
  for (const auto& [mesh, columns] : labels) {
    labelled += meshes.contains(mesh) ? 1 : 0;
    for (const auto& [column, value] : columns) {
      input.labels[mesh][column] = value;
    }
  }
  if (labelled == 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        labels_file, ": none of its ", labels.size(), " files",
        labels.empty() ? "" : absl::StrCat(" (such as ", labels.begin()->first, ")"),
        " is a mesh of ", input.source, " (such as ", input.matrix.labels.front(), ")"));
  }
  if (labelled < std::ssize(meshes)) {
    input.notes.push_back(absl::StrCat(std::ssize(meshes) - labelled, " of ", meshes.size(),
                                       " meshes are not in ", labels_file));
  }
  return absl::OkStatus();
}

absl::Status LabelByName(const std::string& pattern, AnalysisInput& input) {
  COHORT_ASSIGN_OR_RETURN(const NamePattern parsed, NamePattern::Create(pattern));
  std::vector<std::string> others;
  for (const std::string& mesh : input.matrix.labels) {
    const auto labels = parsed.Match(mesh);
    if (!labels) {
      others.push_back(mesh);
      continue;
    }
    for (const auto& [column, value] : *labels) {
      input.labels[mesh][column] = value;
    }
  }
  if (others.size() == input.matrix.labels.size()) {
    return absl::InvalidArgumentError(absl::StrCat("pattern '", pattern, "': no mesh of ",
                                                   input.source, " fits it (such as ",
                                                   others.front(), ")"));
  }
  if (!others.empty()) {
    input.notes.push_back(absl::StrCat("names that do not fit the pattern: ", SomeOf(others)));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> LabelColumn(const AnalysisInput& input,
                                                     const std::string& column) {
  std::vector<std::string> values;
  std::set<std::string> columns;
  for (const std::string& mesh : input.matrix.labels) {
    values.emplace_back();
    const auto labels = input.labels.find(mesh);
    if (labels == input.labels.end()) {
      continue;
    }
    for (const auto& [name, value] : labels->second) {
      columns.insert(name);
      if (name == column && value != "NA") {
        values.back() = value;
      }
    }
  }
  if (!columns.contains(column)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "no mesh of ", input.source, " has a label column '", column, "'",
        columns.empty() ? ", or any other (--labels FILE.csv)"
                        : absl::StrCat("; there are: ", absl::StrJoin(columns, ", "))));
  }
  return values;
}

absl::Status MatchMeshes(std::vector<AnalysisInput>& inputs, OtherMeshes others) {
  if (others == OtherMeshes::kRefuse) {
    COHORT_RETURN_IF_ERROR(RequireSameMeshes(inputs));
  }
  std::vector<std::string> common = inputs.front().matrix.labels;
  for (const AnalysisInput& other : inputs) {
    const std::set<std::string> names = NamesOf(other);
    std::erase_if(common, [&](const std::string& name) { return !names.contains(name); });
  }
  if (common.size() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(common.size(), " meshes are in all of the matrices, at least 3 are needed"));
  }
  for (AnalysisInput& input : inputs) {
    input.matrix = PartOf(input.matrix, RowsOf(input.matrix, common));
  }
  return absl::OkStatus();
}

}  // namespace cohort
