#include "client/output/analysis_text.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "client/analysis_meshes.h"
#include "common/analysis/outliers.h"
#include "common/report/decimal.h"
#include "common/report/matrix_description.h"

namespace cohort {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kShownAxes = 3;
constexpr int kDigits = 3;
constexpr int kBins = 40;

std::string Percent(double share) {
  return FixedDecimal(100 * share, 1) + " %";
}

/// "1.23 mm".
std::string Value(double value, const AnalysisInput& input) {
  const std::string number = ReadableDecimal(value, kDigits);
  return input.unit.empty() ? number : number + " " + input.unit;
}

std::string ClustersLine(const AnalysisInput& input,
                         const AnalysisOptions& options,
                         const Analysis& analysis) {
  const std::vector<Merge>& merges = analysis.dendrogram.merges;
  return fmt::format("clusters:        {} linkage, {} merges from {} to {}\n",
                     LinkageName(options.linkage), merges.size(),
                     Value(merges.front().height, input), Value(merges.back().height, input));
}

std::string OrdinationLine(const Ordination& ordination) {
  if (ordination.explained.empty()) {
    return "pcoa:            no axis: all meshes coincide\n";
  }
  std::string shares;
  for (size_t axis = 0; axis < std::min(kShownAxes, ordination.explained.size()); ++axis) {
    shares += (axis == 0 ? "" : ", ") + Percent(ordination.explained[axis]);
  }
  std::string negative;
  if (ordination.negative > 0) {
    negative =
        fmt::format("; {} of {} eigenvalues are negative ({} of their sum)", ordination.negative,
                    ordination.eigenvalues.size(), Percent(ordination.negative_share));
  }
  return fmt::format("pcoa:            first axes explain {}{}\n", shares, negative);
}

std::string GroupLines(const AnalysisInput& input,
                       const AnalysisOptions& options,
                       const Analysis& analysis) {
  if (!analysis.groups || !analysis.permanova) {
    return "";
  }
  const Permanova& test = *analysis.permanova;
  return fmt::format(
      "{:<17}{} groups of {} meshes; mean within {}, between {}\n"
      "permanova:       F = {}, R2 = {}, p = {} ({} permutations, seed {})\n",
      "by " + options.by + ":", analysis.groups->groups.size(), test.meshes,
      Value(analysis.groups->within.mean, input), Value(analysis.groups->between.mean, input),
      ReadableDecimal(test.f, kDigits), ReadableDecimal(test.r_squared, kDigits),
      ReadableDecimal(test.p, kDigits), test.permutations, options.seed);
}

std::vector<std::string> OutlierNames(const AnalysisInput& input, const OutlierTable& table) {
  std::vector<std::string> names;
  for (size_t row = 0; row < input.matrix.labels.size(); ++row) {
    if (table.IsOutlier(row)) {
      names.push_back(input.matrix.labels[row]);
    }
  }
  return names;
}

std::string OutlierLine(const AnalysisInput& input, const OutlierTable& table) {
  const std::vector<std::string> names = OutlierNames(input, table);
  return fmt::format("outliers:        {}\n",
                     names.empty() ? fmt::format("none (robust z over {})", kOutlierZ)
                                   : fmt::format("{} of {}: {}", names.size(),
                                                 input.matrix.labels.size(), SomeOf(names)));
}

std::string PersonLines(const AnalysisInput& input,
                        const AnalysisOptions& options,
                        const std::string& title,
                        const PersonAnalysis& persons) {
  const Identification& found = persons.identification;
  std::string text =
      fmt::format("{:<17}rank 1: {} of {} searches, rank 5: {}\n", title,
                  Percent(found.ShareAtRank(1)), found.with_mate, Percent(found.ShareAtRank(5)));
  if (persons.verification) {
    const Verification& pairs = *persons.verification;
    text += fmt::format("{:<17}EER {}, d' {}; best balance at {}: FAR {}, FRR {}\n", "",
                        Percent(pairs.equal_error_rate), ReadableDecimal(pairs.d_prime, kDigits),
                        Value(pairs.nearest_equal.threshold, input),
                        Percent(pairs.nearest_equal.false_accept_rate),
                        Percent(pairs.nearest_equal.false_reject_rate));
  }
  if (options.threshold) {
    const ErrorRates rates = RatesAt(persons.scores, *options.threshold);
    text += fmt::format("{:<17}at {}: FAR {}, FRR {}\n", "", Value(rates.threshold, input),
                        Percent(rates.false_accept_rate), Percent(rates.false_reject_rate));
  }
  return text;
}

Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json RatesJson(const ErrorRates& rates) {
  return {{"threshold", Number(rates.threshold)},
          {"false_accept_rate", Number(rates.false_accept_rate)},
          {"false_reject_rate", Number(rates.false_reject_rate)}};
}

Json SummaryJson(const PairSummary& values) {
  return {{"pairs", values.pairs},        {"missing", values.missing},
          {"mean", Number(values.mean)},  {"sd", Number(values.deviation)},
          {"min", Number(values.least)},  {"median", Number(values.median)},
          {"max", Number(values.largest)}};
}

Json PersonJson(const AnalysisOptions& options, const PersonAnalysis& persons) {
  const Identification& found = persons.identification;
  Json json = {{"searches", found.searches.size()},
               {"with_mate", found.with_mate},
               {"match_share", found.match_share},
               {"genuine_pairs", persons.scores.genuine.size()},
               {"impostor_pairs", persons.scores.impostor.size()},
               {"missing_pairs", persons.scores.missing},
               {"unknown_pairs", persons.scores.unknown}};
  if (persons.verification) {
    const Verification& pairs = *persons.verification;
    json["equal_error_rate"] = pairs.equal_error_rate;
    json["nearest_equal"] = RatesJson(pairs.nearest_equal);
    json["d_prime"] = Number(pairs.d_prime);
    json["area_under_roc"] = pairs.area;
    for (const double far : {0.1, 0.01, 0.001}) {
      json["at_false_accept_rate"].push_back(RatesJson(RatesAtFalseAccepts(persons.scores, far)));
    }
  }
  const ScoreHistogram histogram = HistogramOf(persons.scores, kBins);
  json["histogram"] = {{"first", histogram.first},
                       {"width", histogram.width},
                       {"genuine", histogram.genuine},
                       {"impostor", histogram.impostor}};
  if (options.threshold) {
    json["at_threshold"] = RatesJson(RatesAt(persons.scores, *options.threshold));
  }
  return json;
}

Json GroupsJson(const AnalysisOptions& options, const Analysis& analysis) {
  const Permanova& test = *analysis.permanova;
  Json json = {{"by", options.by},
               {"groups", analysis.groups->groups},
               {"sizes", analysis.groups->sizes},
               {"within", SummaryJson(analysis.groups->within)},
               {"between", SummaryJson(analysis.groups->between)}};
  json["permanova"] = {{"f", Number(test.f)},
                       {"r_squared", test.r_squared},
                       {"p", test.p},
                       {"as_extreme", test.as_extreme},
                       {"permutations", test.permutations},
                       {"seed", options.seed},
                       {"df", {test.groups - 1, test.meshes - test.groups}},
                       {"sum_of_squares",
                        {{"groups", test.sum_of_squares_groups},
                         {"residual", test.sum_of_squares_residual},
                         {"total", test.sum_of_squares_total}}}};
  return json;
}

}  // namespace

std::string AnalysisToText(const AnalysisInput& input,
                           const AnalysisOptions& options,
                           const Analysis& analysis) {
  std::string text = fmt::format(
      "{}: {}{}{}\n", input.source, Counted(std::ssize(input.matrix.labels), "mesh", "meshes"),
      input.metric.empty() ? "" : ", " + input.metric,
      input.rejected.empty() ? "" : fmt::format(" ({} rejected)", input.rejected.size()));
  text += ClustersLine(input, options, analysis) + OrdinationLine(analysis.ordination);
  text += GroupLines(input, options, analysis) + OutlierLine(input, analysis.outliers);
  if (analysis.identification) {
    text += PersonLines(input, options, "identification:", *analysis.identification);
  }
  if (analysis.other_sessions) {
    text += PersonLines(input, options, "other sessions:", *analysis.other_sessions);
  }
  for (const std::vector<std::string>* notes : {&input.notes, &analysis.notes}) {
    for (const std::string& note : *notes) {
      text += "note: " + note + "\n";
    }
  }
  return text;
}

Json AnalysisToJson(const AnalysisInput& input,
                    const AnalysisOptions& options,
                    const Analysis& analysis) {
  Json json = {{"source", input.source},
               {"meshes", input.matrix.labels.size()},
               {"rejected", input.rejected},
               {"incomplete", analysis.incomplete},
               {"metric", input.metric.empty() ? Json() : Json(input.metric)},
               {"unit", input.unit},
               {"neighbours", options.neighbours}};
  const std::vector<Merge>& merges = analysis.dendrogram.merges;
  json["clusters"] = {{"linkage", std::string(LinkageName(options.linkage))},
                      {"merges", merges.size()},
                      {"lowest", merges.front().height},
                      {"highest", merges.back().height},
                      {"cut", options.clusters}};
  const Ordination& ordination = analysis.ordination;
  json["pcoa"] = {{"axes", ordination.explained.size()},
                  {"explained", ordination.explained},
                  {"negative_eigenvalues", ordination.negative},
                  {"negative_share", ordination.negative_share}};
  json["outliers"] = OutlierNames(input, analysis.outliers);
  json["groups"] = analysis.groups ? GroupsJson(options, analysis) : Json();
  json["identification"] =
      analysis.identification ? PersonJson(options, *analysis.identification) : Json();
  json["other_sessions"] =
      analysis.other_sessions ? PersonJson(options, *analysis.other_sessions) : Json();
  json["notes"] = input.notes;
  for (const std::string& note : analysis.notes) {
    json["notes"].push_back(note);
  }
  return json;
}

}  // namespace cohort
