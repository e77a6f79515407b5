#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "common/report/decimal.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/markup.h"
#include "common/report/pair_distribution.h"

namespace cohort {
namespace {

std::string Figure(const std::string& name, const std::string& value) {
  return "<div><dt>" + EscapeMarkup(name) + "</dt><dd>" + EscapeMarkup(value) + "</dd></div>\n";
}

// Meshes whose nearest mesh is of the same person, of those that have another one.
std::string NearestSamePerson(const ReportInput& input) {
  int64_t with_other = 0;
  int64_t same = 0;
  for (size_t row = 0; row < input.neighbours.size(); ++row) {
    const std::string& person = input.persons[row];
    if (person.empty() || std::count(input.persons.begin(), input.persons.end(), person) < 2) {
      continue;
    }
    ++with_other;
    if (input.neighbours[row].empty()) continue;
    same += input.persons[static_cast<size_t>(input.neighbours[row][0].column)] == person ? 1 : 0;
  }
  if (with_other == 0) return "";
  return std::to_string(same) + " of " + std::to_string(with_other);
}

std::string DistanceFigures(const ReportInput& input) {
  const PairValues pairs = CollectPairs(input.matrix, input.description.symmetrization, {});
  const std::span<const double> values = pairs.different;
  if (values.empty()) return "";
  const auto number = [&](double value) {
    return WithUnit(ReadableDecimal(value, 3), input.description);
  };
  std::string html = Figure("smallest of all pairs", number(values.front()));
  html += Figure("median", number(MedianOfSorted(values)));
  html += Figure("largest", number(values.back()));
  if (pairs.missing > 0) html += Figure("pairs without a value", std::to_string(pairs.missing));
  return html;
}

std::string Notes(const ReportInput& input) {
  if (input.notes.empty()) return "";
  std::string html = "<ul class=\"notes\">\n";
  for (const std::string& note : input.notes) html += "<li>" + EscapeMarkup(note) + "</li>\n";
  return html + "</ul>\n";
}

std::string PairText(Symmetrization symmetrization) {
  switch (symmetrization) {
    case Symmetrization::kMean:
      return "the value of a pair is the mean of both directions";
    case Symmetrization::kMax:
      return "the value of a pair is the larger of both directions";
    case Symmetrization::kDirected:
      return "each direction has its own value: row is the source (its vertices are measured), "
             "column the target";
  }
  return "";
}

// Says nothing of the results, or only where they came from.
bool IsLeftOut(const std::string& key) {
  return key == "priority" || key == "fresh" || key == "reference_job";
}

void AddParameters(const std::string& prefix, const nlohmann::json& json, HtmlTable& table) {
  for (const auto& [key, value] : json.items()) {
    if (prefix.empty() && IsLeftOut(key)) continue;
    const std::string name = prefix.empty() ? key : absl::StrCat(prefix, ".", key);
    if (value.is_object()) {
      AddParameters(name, value, table);
      continue;
    }
    using nlohmann::json;
    const std::string text = value.is_string()
                                 ? value.get<std::string>()
                                 : value.dump(-1, ' ', false, json::error_handler_t::replace);
    table.AddRow({EscapeMarkup(name), text.empty() ? "-" : EscapeMarkup(text)});
  }
}

}  // namespace

std::string SummarySection(const ReportInput& input, const ReportAnalysis& analysis) {
  const auto used = static_cast<int64_t>(input.matrix.labels.size());
  const auto rejected = static_cast<int64_t>(input.meshes.size()) - used;
  const int64_t flagged = std::count_if(analysis.flags.begin(), analysis.flags.end(),
                                        [](const MeshFlags& one) { return one.Any(); });
  std::string html = "<dl class=\"figures\">\n";
  html += Figure("meshes compared", std::to_string(used));
  html += Figure("rejected", std::to_string(rejected));
  html += Figure("flagged", std::to_string(flagged));
  html += Figure("directed pairs", std::to_string(used * used));
  html += DistanceFigures(input);
  const std::string same = NearestSamePerson(input);
  if (!same.empty()) html += Figure("nearest is the same person", same);
  html += "</dl>\n";
  html +=
      HtmlHint(MetricText(input.description) + ", " + PairText(input.description.symmetrization) +
               ". " + MethodText(input.description) + ".");
  html += Notes(input);
  return HtmlSection("summary", "Summary", html);
}

std::string ParametersSection(const ReportInput& input) {
  HtmlTable table("", {{"parameter"}, {"value"}});
  AddParameters("", ToJson(input.job.spec), table);
  return HtmlSection("parameters", "Parameters",
                     "<details>\n<summary>All " + std::to_string(table.RowCount()) +
                         " parameters of the job</summary>\n" + table.Html() + "</details>\n" +
                         HtmlHint("Input hashes, counters, times and the host are in job.json "
                                  "beside this file. Made with " +
                                  input.software_version + "."));
}

}  // namespace cohort
