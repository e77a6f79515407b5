#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/evaluation/evaluation.h"
#include "common/analysis/agreement.h"
#include "common/analysis/mantel.h"
#include "common/base/status_macros.h"
#include "common/report/decimal.h"
#include "common/report/heatmap.h"

namespace cohort {
namespace {

constexpr double kExpectedShare = 0.9;
constexpr int64_t kPermutations = 9999;

std::string Share(int64_t part, int64_t all) {
  return absl::StrCat(part, "/", all);
}

/// Tables 5.7 and 5.8: is the nearest mesh the same person, and how much nearer?
absl::Status AddPersons(Evaluation& evaluation, Lab& lab) {
  const std::string claim =
      "the nearest mesh of each mesh is the same person, for RMS, P75 and "
      "geometric mean";
  Findings& findings = evaluation.findings;
  if (!evaluation.has_persons) {
    findings.NotTested("5.7", PropertyClass::kOrdinal, claim,
                       "needs --labels with a column person, "
                       "or --person-before");
    findings.NotTested("5.8", PropertyClass::kOrdinal, "same person nearer than the next",
                       "as 5.7");
    return absl::OkStatus();
  }
  const Density& density = evaluation.Middle();
  EvaluationTable ranks{"5.7",
                        "nearest mesh is the same person, " + density.name,
                        {"strategy", "RMS", "P75", "geometric mean"},
                        {},
                        "8/8 for all three"};
  EvaluationTable values{"5.8",
                         "RMS (mm) of the nearest mesh of the same and of another person",
                         {"mesh", "strategy", "same", "next", "same / next"},
                         {},
                         "same 1.09-1.38, next 2.34-3.40, ratio 0.35-0.55"};
  bool all_first = true;
  double largest_ratio = 0;
  for (size_t s = 0; s < kStrategies.size(); ++s) {
    std::vector<std::string> row = {StrategyName(s)};
    for (const Metric metric : {Metric::kRms, Metric::kPercentile75, Metric::kGeometricMean}) {
      COHORT_ASSIGN_OR_RETURN(const MetricMatrix matrix, lab.Matrix(density.runs[s], metric));
      COHORT_ASSIGN_OR_RETURN(
          const Identification found,
          IdentifyPersons(matrix, evaluation.IdentitiesOf(matrix), Gallery::kAllOthers));
      const auto first = std::count_if(found.searches.begin(), found.searches.end(),
                                       [](const ProbeSearch& search) { return search.rank == 1; });
      all_first = all_first && first == found.with_mate && found.with_mate > 0;
      row.push_back(Share(first, found.with_mate));
      for (const ProbeSearch& search : found.searches) {
        if (metric != Metric::kRms || search.mate < 0 || search.impostor < 0) continue;
        const double ratio = search.mate_value / search.impostor_value;
        largest_ratio = std::max(largest_ratio, ratio);
        values.rows.push_back({matrix.labels[static_cast<size_t>(search.probe)], StrategyName(s),
                               FixedDecimal(search.mate_value, 3),
                               FixedDecimal(search.impostor_value, 3), FixedDecimal(ratio, 3)});
      }
    }
    ranks.rows.push_back(row);
  }
  findings.tables.push_back(ranks);
  findings.tables.push_back(values);
  findings.Check("5.7", PropertyClass::kOrdinal, claim, "8/8", "see table 5.7", all_first);
  findings.Check("5.8", PropertyClass::kOrdinal, "same person nearer than the next, for every mesh",
                 "ratio 0.35-0.55", "largest ratio " + FixedDecimal(largest_ratio, 3),
                 largest_ratio < 1);
  findings.Check("5.8", PropertyClass::kRange, "ratio below 0.7", "0.35-0.55",
                 "largest " + FixedDecimal(largest_ratio, 3), largest_ratio < 0.7);
  return absl::OkStatus();
}

/// To One and To Average against To Each, of the same parameters.
struct Agreements {
  NeighbourAgreement one;
  NeighbourAgreement average;
};

absl::StatusOr<Agreements> Agree(const std::array<const Experiment*, 3>& runs) {
  Agreements agree;
  COHORT_ASSIGN_OR_RETURN(agree.one, CompareNeighbours(runs[kEach]->rms, runs[kOne]->rms, kTriad));
  COHORT_ASSIGN_OR_RETURN(agree.average,
                          CompareNeighbours(runs[kEach]->rms, runs[kAverage]->rms, kTriad));
  return agree;
}

EvaluationTable TriadTable(const std::string& item,
                           const std::string& title,
                           const Agreements& agree,
                           const std::string& thesis) {
  EvaluationTable table{item,
                        title,
                        {"against To Each", "correct", "wrong order", "one missed", "two missed",
                         "three missed", "neighbours kept", "same nearest"},
                        {},
                        thesis};
  for (const auto& [name, agreement] :
       {std::pair{"To One", &agree.one}, std::pair{"To Average", &agree.average}}) {
    table.rows.push_back({name, absl::StrCat(agreement->correct),
                          absl::StrCat(agreement->wrong_order), absl::StrCat(agreement->missed[0]),
                          absl::StrCat(agreement->missed[1]), absl::StrCat(agreement->missed[2]),
                          Share(agreement->kept, agreement->wanted),
                          Share(agreement->same_nearest, std::ssize(agreement->rows))});
  }
  return table;
}

void CheckTriads(const std::string& item, const Agreements& agree, Findings& findings) {
  const NeighbourAgreement& one = agree.one;
  const NeighbourAgreement& average = agree.average;
  const std::string seen =
      absl::StrCat("correct ", one.correct, " and ", average.correct, ", two missed ",
                   one.missed[1], " and ", average.missed[1], ", three missed ", one.missed[2],
                   " and ", average.missed[2], ", kept ", Share(one.kept, one.wanted), " and ",
                   Share(average.kept, average.wanted), " (One and Average)");
  findings.Check(item, PropertyClass::kOrdinal,
                 "triads of To Average agree with To Each at least as well as those of To One; "
                 "none misses three; at least 44 of 60 neighbours kept",
                 "kept 44/60 and 48-51/60", seen,
                 average.correct >= one.correct && average.missed[1] <= one.missed[1] &&
                     average.missed[2] == 0 && one.missed[2] == 0 && average.kept >= one.kept &&
                     60 * one.kept >= 44 * one.wanted);
}

void CheckNearest(const Agreements& agree, Findings& findings) {
  const auto rows = std::ssize(agree.average.rows);
  findings.Check("appendix", PropertyClass::kOrdinal,
                 "nearest face of To Each kept by To Average at least as often as by To One, and "
                 "by 90 %",
                 "One 18/20, Average 19/20",
                 absl::StrCat("One ", Share(agree.one.same_nearest, rows), ", Average ",
                              Share(agree.average.same_nearest, rows)),
                 agree.average.same_nearest >= agree.one.same_nearest &&
                     static_cast<double>(agree.average.same_nearest) >=
                         kExpectedShare * static_cast<double>(rows));
}

/// A table of triads with other parameters than the thesis's defaults.
struct Variant {
  int iterations;
  double tolerance;  ///< mm
  const char* item;
  const char* title;
  const char* thesis;
};

absl::StatusOr<Agreements> AddTriadsOf(Evaluation& evaluation, Lab& lab, const Variant& variant) {
  const Density& density = evaluation.Middle();
  std::array<Experiment, 3> runs;
  for (size_t s = 0; s < kStrategies.size(); ++s) {
    COHORT_ASSIGN_OR_RETURN(
        runs[s],
        lab.Run(density.set, ThesisSpec(kStrategies[s], variant.iterations, variant.tolerance),
                Timing::kAnyTime));
  }
  COHORT_ASSIGN_OR_RETURN(Agreements agree, Agree({&runs[0], &runs[1], &runs[2]}));
  evaluation.findings.tables.push_back(TriadTable(
      variant.item, std::string(variant.title) + ", " + density.name, agree, variant.thesis));
  return agree;
}

absl::Status AddTriads(Evaluation& evaluation, Lab& lab) {
  Findings& findings = evaluation.findings;
  if (evaluation.MeshCount() < int64_t{2} * kTriad) {
    findings.NotTested("5.9-5.13", PropertyClass::kOrdinal, "triads agree", "needs 6 meshes");
    return absl::OkStatus();
  }
  constexpr std::array<const char*, 3> kThesis = {
      "correct, wrong order, one, two missed: 4,2,12,2 / 5,3,12,0",
      "6,1,10,3 / 10,1,9,0 (appendix)", "4,2,12,2 / 9,2,9,0"};
  Agreements middle;
  for (size_t i = 0; i < evaluation.densities.size(); ++i) {
    const Density& density = evaluation.densities[i];
    COHORT_ASSIGN_OR_RETURN(const Agreements agree,
                            Agree({&density.runs[0], &density.runs[1], &density.runs[2]}));
    const std::string item = absl::StrCat("5.", 9 + std::min<size_t>(i, 2));
    findings.tables.push_back(
        TriadTable(item, "triads, " + density.name, agree, kThesis[std::min<size_t>(i, 2)]));
    CheckTriads(item, agree, findings);
    if (&density == &evaluation.Middle()) middle = agree;
  }
  CheckNearest(middle, findings);
  COHORT_ASSIGN_OR_RETURN(
      const Agreements fewer,
      AddTriadsOf(evaluation, lab, {20, 0.05, "5.12", "triads with I = 20", "4,2,12,2 / 9,2,7,2"}));
  findings.Check(
      "5.12", PropertyClass::kOrdinal,
      "fewer iterations (I = 20) do not make To Average agree better", "9+2 of 10+1",
      absl::StrCat(fewer.average.correct + fewer.average.wrong_order, " right triads, with I = 40 ",
                   middle.average.correct + middle.average.wrong_order),
      fewer.average.correct + fewer.average.wrong_order <=
          middle.average.correct + middle.average.wrong_order);
  COHORT_ASSIGN_OR_RETURN(
      const Agreements looser,
      AddTriadsOf(evaluation, lab, {40, 0.1, "5.13", "triads with e = 0.1", "3,2,13,2 / 7,4,7,2"}));
  findings.Check(
      "5.13", PropertyClass::kOrdinal,
      "a looser stop (e = 0.1) does not make To Average agree better", "7 of 10",
      absl::StrCat(looser.average.correct, " correct, with e = 0.05 ", middle.average.correct),
      looser.average.correct <= middle.average.correct);
  return absl::OkStatus();
}

absl::Status AddCloseness(Evaluation& evaluation) {
  const Density& density = evaluation.densities.back();
  const MetricMatrix& each = density.runs[kEach].rms;
  const MetricMatrix& one = density.runs[kOne].rms;
  const MetricMatrix& average = density.runs[kAverage].rms;
  COHORT_ASSIGN_OR_RETURN(const Closeness closer, CompareCloseness(average, one, each));
  const int64_t n = evaluation.MeshCount();
  evaluation.findings.tables.push_back({"figure 5.6",
                                        "cells closer to To Each, " + density.name,
                                        {"To Average", "To One", "equal", "all"},
                                        {{absl::StrCat(closer.first), absl::StrCat(closer.second),
                                          absl::StrCat(closer.equal), absl::StrCat(n * n)}},
                                        "204 / 176 / 20 of 400"});
  evaluation.findings.Check("fig. 5.6", PropertyClass::kOrdinal, "only the diagonal is equal",
                            "20 of 400", absl::StrCat(closer.equal), closer.equal == n);
  evaluation.findings.Check(
      "fig. 5.6", PropertyClass::kRange, "To Average is closer to To Each in half of the cells",
      "204 of 380", absl::StrCat(closer.first, " of ", n * n - n), 2 * closer.first >= n * n - n);
  MetricMatrix gain = one;
  gain.values = (one.values - each.values).cwiseAbs() - (average.values - each.values).cwiseAbs();
  MatrixDescription description;
  description.title = "How much closer To Average is to To Each than To One";
  description.subtitle = "|One - Each| - |Average - Each| of the RMS distance; " + density.name;
  COHORT_ASSIGN_OR_RETURN(std::string png, HeatmapPng(gain, description));
  evaluation.findings.pictures.push_back({"figure_5_6.png", description.title, std::move(png)});
  return absl::OkStatus();
}

absl::Status AddMantel(Evaluation& evaluation,
                       const std::string& item,
                       int iterations,
                       const std::string& thesis,
                       const std::array<const MetricMatrix*, 3>& matrices) {
  MantelOptions options;
  options.permutations = kPermutations;
  EvaluationTable table{
      item,
      absl::StrCat("Mantel test, I = ", iterations, ", ", evaluation.Middle().name),
      {"matrices", "r", "p"},
      {},
      thesis};
  std::vector<double> r;
  std::vector<double> p;
  for (const auto& [a, b] : {std::pair{kEach, kOne}, {kEach, kAverage}, {kOne, kAverage}}) {
    COHORT_ASSIGN_OR_RETURN(const MantelResult result,
                            MantelTest(*matrices[a], *matrices[b], options, evaluation.executor));
    r.push_back(result.r);
    p.push_back(result.p);
    table.rows.push_back({StrategyName(a) + ", " + StrategyName(b), FixedDecimal(result.r, 4),
                          FixedDecimal(result.p, 4)});
  }
  evaluation.findings.tables.push_back(table);
  const std::string seen = absl::StrCat("r ", FixedDecimal(r[0], 4), ", ", FixedDecimal(r[1], 4),
                                        ", ", FixedDecimal(r[2], 4), "; largest p ",
                                        FixedDecimal(*std::max_element(p.begin(), p.end()), 4));
  evaluation.findings.Check(
      item, PropertyClass::kOrdinal, "all three correlate above 0.9, To One with To Average most",
      thesis, seen,
      *std::min_element(r.begin(), r.end()) > kExpectedShare && r[2] >= r[0] && r[2] >= r[1]);
  if (evaluation.MeshCount() >= 10) {
    evaluation.findings.Check(item, PropertyClass::kOrdinal, "p is at its minimum, 1 / (9999 + 1)",
                              "0.0001", seen,
                              *std::max_element(p.begin(), p.end()) <= 1.0 / (kPermutations + 1));
  } else {
    evaluation.findings.NotTested(item, PropertyClass::kOrdinal, "p is at its minimum",
                                  "under 10 meshes some permutations repeat the order");
  }
  return absl::OkStatus();
}

absl::Status AddMantels(Evaluation& evaluation, Lab& lab) {
  if (evaluation.MeshCount() < 4) {
    evaluation.findings.NotTested("5.14-5.15", PropertyClass::kOrdinal, "matrices correlate",
                                  "needs 4 meshes");
    return absl::OkStatus();
  }
  const Density& density = evaluation.Middle();
  std::array<Experiment, 3> fewer;
  for (size_t s = 0; s < kStrategies.size(); ++s) {
    COHORT_ASSIGN_OR_RETURN(
        fewer[s], lab.Run(density.set, ThesisSpec(kStrategies[s], 20, 0.05), Timing::kAnyTime));
  }
  COHORT_RETURN_IF_ERROR(AddMantel(evaluation, "5.14", 20, "0.9509, 0.9478, 0.9844; p 0.0001",
                                   {&fewer[0].rms, &fewer[1].rms, &fewer[2].rms}));
  return AddMantel(evaluation, "5.15", 40, "0.9509, 0.9473, 0.9838; p 0.0001",
                   {&density.runs[0].rms, &density.runs[1].rms, &density.runs[2].rms});
}

}  // namespace

absl::Status EvaluateNeighbours(Evaluation& evaluation, Lab& lab) {
  COHORT_RETURN_IF_ERROR(AddPersons(evaluation, lab));
  COHORT_RETURN_IF_ERROR(AddTriads(evaluation, lab));
  COHORT_RETURN_IF_ERROR(AddCloseness(evaluation));
  return AddMantels(evaluation, lab);
}

}  // namespace cohort
