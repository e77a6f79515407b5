#include <algorithm>
#include <cmath>
#include <numeric>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "client/evaluation/evaluation.h"
#include "client/job_frame.h"
#include "common/base/status_macros.h"
#include "common/report/decimal.h"

namespace cohort {
namespace {

constexpr int kIterations = 40;
constexpr double kTolerance = 0.05;
constexpr int kForcedIterations = 60;
constexpr int kRounds = 3;

std::string Seconds(double seconds) {
  return FixedDecimal(seconds, 3);
}

int64_t TotalVertices(const Density& density) {
  const std::vector<int64_t>& vertices = density.forced[kOne].vertices;
  return std::accumulate(vertices.begin(), vertices.end(), int64_t{0});
}

absl::Status RunAll(Evaluation& evaluation, Lab& lab) {
  for (Density& density : evaluation.densities) {
    COHORT_RETURN_IF_ERROR(lab.AddSet(density.set, density.files));
    // Ingests the meshes, which is no part of the times.
    COHORT_RETURN_IF_ERROR(
        lab.Run(density.set, ThesisSpec(Method::kNone, 1, 0), Timing::kAnyTime).status());
    for (size_t i = 0; i < kStrategies.size(); ++i) {
      COHORT_ASSIGN_OR_RETURN(
          density.runs[i], lab.Run(density.set, ThesisSpec(kStrategies[i], kIterations, kTolerance),
                                   Timing::kTimed));
      COHORT_ASSIGN_OR_RETURN(
          density.forced[i],
          lab.Run(density.set, ThesisSpec(kStrategies[i], kForcedIterations, 0), Timing::kTimed));
      evaluation.say(absl::StrCat(density.name, ", ", StrategyName(i), ": ",
                                  Seconds(density.runs[i].seconds), " s, forced ",
                                  Seconds(density.forced[i].seconds), " s"));
    }
    density.vertices =
        static_cast<double>(TotalVertices(density)) / static_cast<double>(evaluation.MeshCount());
  }
  std::stable_sort(evaluation.densities.begin(), evaluation.densities.end(),
                   [](const Density& a, const Density& b) { return a.vertices < b.vertices; });
  return absl::OkStatus();
}

using RunsOf = std::array<Experiment, 3> Density::*;

EvaluationTable TimeTable(const Evaluation& evaluation,
                          RunsOf runs,
                          const std::string& item,
                          const std::string& title,
                          const std::string& thesis) {
  EvaluationTable table{item,
                        title,
                        {"meshes", "vertices", "To Each (s)", "To One (s)", "To Average (s)",
                         "Each / Average", "Average / One"},
                        {},
                        thesis};
  for (const Density& density : evaluation.densities) {
    const auto& row = density.*runs;
    table.rows.push_back({density.name, FixedDecimal(density.vertices, 0),
                          Seconds(row[kEach].seconds), Seconds(row[kOne].seconds),
                          Seconds(row[kAverage].seconds),
                          FixedDecimal(row[kEach].seconds / row[kAverage].seconds, 2),
                          FixedDecimal(row[kAverage].seconds / row[kOne].seconds, 2)});
  }
  return table;
}

/// Ratio of two strategies at each density, as text.
std::string Ratios(const Evaluation& evaluation, RunsOf runs, size_t above, size_t below) {
  std::vector<std::string> texts;
  for (const Density& density : evaluation.densities) {
    texts.push_back(
        FixedDecimal((density.*runs)[above].seconds / (density.*runs)[below].seconds, 2));
  }
  return absl::StrJoin(texts, ", ");
}

bool Everywhere(const Evaluation& evaluation, const std::function<bool(const Density&)>& holds) {
  return std::all_of(evaluation.densities.begin(), evaluation.densities.end(), holds);
}

void AddTimes(Evaluation& evaluation) {
  Findings& findings = evaluation.findings;
  findings.tables.push_back(
      TimeTable(evaluation, &Density::runs, "5.1", "time of alignment and averaging, one thread",
                "5k 182.6/5.8/45.5, 10k 308/85/158, 20k 791/252/541 s (Each/One/Average)"));
  findings.Check("5.1", PropertyClass::kOrdinal,
                 "To One is faster than To Average, that faster "
                 "than To Each, at every density",
                 "so",
                 "Each / Average " + Ratios(evaluation, &Density::runs, kEach, kAverage) +
                     "; Average / One " + Ratios(evaluation, &Density::runs, kAverage, kOne),
                 Everywhere(evaluation, [](const Density& d) {
                   return d.runs[kOne].seconds < d.runs[kAverage].seconds &&
                          d.runs[kAverage].seconds < d.runs[kEach].seconds;
                 }));
  findings.tables.push_back(TimeTable(evaluation, &Density::forced, "5.3",
                                      "the same with all 60 iterations (e = 0)",
                                      "660/35/69, 1605/88/212, 3801/206/678 s"));
  const std::string look_ups = " (look-ups alone: 19.0 at 20 meshes)";
  if (evaluation.MeshCount() >= 20) {
    findings.Check("5.3", PropertyClass::kOrdinal, "To Each takes 5 times To Average or more",
                   "9.6, 7.6, 5.6",
                   Ratios(evaluation, &Density::forced, kEach, kAverage) + look_ups,
                   Everywhere(evaluation, [](const Density& d) {
                     return d.forced[kEach].seconds >= 5 * d.forced[kAverage].seconds;
                   }));
  } else {
    findings.NotTested(
        "5.3", PropertyClass::kOrdinal, "To Each takes 5 times To Average or more",
        "needs 20 meshes; here " + Ratios(evaluation, &Density::forced, kEach, kAverage));
  }
  findings.Check("5.3", PropertyClass::kOrdinal, "To Average takes 1 to 4 times To One",
                 "1.9, 2.4, 3.3", Ratios(evaluation, &Density::forced, kAverage, kOne),
                 Everywhere(evaluation, [](const Density& d) {
                   const double ratio = d.forced[kAverage].seconds / d.forced[kOne].seconds;
                   return ratio >= 1 && ratio <= 4;
                 }));
}

/// Exponent of the growth from the least to the most dense.
double Slope(const Evaluation& evaluation, size_t strategy) {
  const Density& first = evaluation.densities.front();
  const Density& last = evaluation.densities.back();
  return std::log(last.forced[strategy].seconds / first.forced[strategy].seconds) /
         std::log(last.vertices / first.vertices);
}

void AddGrowth(Evaluation& evaluation) {
  Findings& findings = evaluation.findings;
  const std::string claim =
      "time grows with the vertices, of To Each at least as steeply as of To "
      "Average";
  if (evaluation.densities.size() < 2) {
    findings.NotTested("fig. 5.3-5.4", PropertyClass::kOrdinal, claim,
                       "needs the set at several densities");
    return;
  }
  bool grows = true;
  for (size_t i = 1; i < evaluation.densities.size(); ++i) {
    for (size_t s = 0; s < kStrategies.size(); ++s) {
      grows = grows && evaluation.densities[i].forced[s].seconds >
                           evaluation.densities[i - 1].forced[s].seconds;
    }
  }
  const double each = Slope(evaluation, kEach);
  const double average = Slope(evaluation, kAverage);
  findings.Check(
      "fig. 5.3-5.4", PropertyClass::kOrdinal, claim, "To Each steepest",
      absl::StrCat("exponents ", FixedDecimal(each, 2), " and ", FixedDecimal(average, 2)),
      grows && each >= average - 0.05);
}

/// Passes of one alignment (To Average: summed over its rounds), in the mean.
double MeanPasses(const Evaluation& evaluation, const Density& density, size_t strategy) {
  const double alignments = static_cast<double>(evaluation.MeshCount()) *
                            (strategy == kEach ? static_cast<double>(evaluation.MeshCount()) : 1);
  return static_cast<double>(density.runs[strategy].job.counters.align.lookups) /
         (alignments * density.vertices);
}

absl::Status AddPasses(Evaluation& evaluation, Lab& lab) {
  EvaluationTable table{"5.2",
                        "iterations until e = 0.05 mm",
                        {"meshes", "To Each, mean", "To One, mean", "To One, largest",
                         "To Average, mean over all rounds", "not converged, To One"},
                        {},
                        "largest 17-18 / 9-10 / 22-25 (Average summed over rounds)"};
  bool stops = true;
  for (const Density& density : evaluation.densities) {
    COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs,
                            lab.GetSession().GetOutputs(density.runs[kOne].job.id));
    int largest = 0;
    int not_converged = 0;
    for (const Digest& blob : outputs.alignments) {
      COHORT_ASSIGN_OR_RETURN(const std::string bytes, lab.GetSession().Blobs().Get(blob));
      COHORT_ASSIGN_OR_RETURN(const auto alignments, DecodeAlignmentBlob(bytes));
      for (const MeshAlignment& mesh : alignments) {
        largest = std::max(largest, mesh.alignment.iterations);
        not_converged += mesh.alignment.converged ? 0 : 1;
      }
    }
    const double each = MeanPasses(evaluation, density, kEach);
    const double average = MeanPasses(evaluation, density, kAverage);
    stops = stops && not_converged == 0 && each < kIterations && average <= kIterations;
    table.rows.push_back({density.name, FixedDecimal(each, 1),
                          FixedDecimal(MeanPasses(evaluation, density, kOne), 1),
                          absl::StrCat(largest), FixedDecimal(average, 1),
                          absl::StrCat(not_converged)});
  }
  evaluation.findings.tables.push_back(table);
  evaluation.findings.Check(
      "5.2", PropertyClass::kOrdinal,
      "every ICP To One stops before its cap; To Each in the mean; To Average within 40 in all",
      "so", "see table 5.2", stops);
  return absl::OkStatus();
}

/// What the formulas of tables 5.4 and 5.5 give.
WorkCounters ExpectedWork(const Evaluation& evaluation, const Density& density, size_t strategy) {
  const int64_t n = evaluation.MeshCount();
  const int64_t total = TotalVertices(density);
  switch (strategy) {
    case kEach:
      return {.index_builds = n, .lookups = n * total * kForcedIterations};
    case kOne:
      return {.index_builds = 1, .lookups = total * kForcedIterations};
    default:
      break;
  }
  // The mean shape has the vertices of the base mesh, the first one.
  const int64_t base = density.forced[kAverage].vertices.front();
  return {.index_builds = n * kRounds + kRounds + 1,
          .lookups = total * kForcedIterations + n * kRounds * base};
}

void AddCounters(Evaluation& evaluation) {
  EvaluationTable builds{"5.4",
                         "search structures built by alignment and averaging",
                         {"meshes", "To Each", "To One", "To Average", "N; 1; NM + M + 1"},
                         {},
                         "20 / 1 / 64"};
  EvaluationTable lookups{"5.5",
                          "nearest-vertex look-ups of alignment and averaging",
                          {"meshes", "strategy", "counted", "formula"},
                          {},
                          "24000 n / 1200 n / 1260 n"};
  bool same_builds = true;
  bool same_lookups = true;
  for (const Density& density : evaluation.densities) {
    std::vector<std::string> row = {density.name};
    std::vector<std::string> formula;
    for (size_t s = 0; s < kStrategies.size(); ++s) {
      const WorkCounters counted = density.forced[s].ThesisCounters();
      const WorkCounters expected = ExpectedWork(evaluation, density, s);
      same_builds = same_builds && counted.index_builds == expected.index_builds;
      same_lookups = same_lookups && counted.lookups == expected.lookups;
      row.push_back(absl::StrCat(counted.index_builds));
      formula.push_back(absl::StrCat(expected.index_builds));
      lookups.rows.push_back({density.name, StrategyName(s), absl::StrCat(counted.lookups),
                              absl::StrCat(expected.lookups)});
    }
    row.push_back(absl::StrJoin(formula, "; "));
    builds.rows.push_back(row);
  }
  evaluation.findings.tables.push_back(builds);
  evaluation.findings.tables.push_back(lookups);
  evaluation.findings.Check("5.4", PropertyClass::kFormula, "search structures: N; 1; N M + M + 1",
                            "20 / 1 / 64", "see table 5.4", same_builds);
  evaluation.findings.Check("5.5", PropertyClass::kFormula,
                            "look-ups: N sum(n) I; sum(n) I; sum(n) I_avg (M + 1) + N M n_base",
                            "24000n / 1200n / 1260n", "see table 5.5", same_lookups);
}

/// The densest set once more with a worker per processor.
absl::Status AddSpeedUp(Evaluation& evaluation) {
  const int workers = LocalThreads();
  Density& densest = evaluation.densities.back();
  const std::string claim = "speed-up of P workers at least 0.7 P, and the same bytes";
  if (workers < 2 || evaluation.MeshCount() < int64_t{4} * workers) {
    evaluation.findings.NotTested(
        "5.6", PropertyClass::kOrdinal, claim,
        absl::StrCat("needs several processors and 4 meshes for each; here ", workers));
    return absl::OkStatus();
  }
  COHORT_ASSIGN_OR_RETURN(const auto lab, Lab::Start(evaluation.data / "parallel", workers));
  COHORT_RETURN_IF_ERROR(lab->AddSet(densest.set, densest.files));
  COHORT_RETURN_IF_ERROR(
      lab->Run(densest.set, ThesisSpec(Method::kNone, 1, 0), Timing::kAnyTime).status());
  COHORT_ASSIGN_OR_RETURN(
      const Experiment run,
      lab->Run(densest.set, ThesisSpec(Method::kEach, kForcedIterations, 0), Timing::kTimed));
  const double speed_up = densest.forced[kEach].seconds / run.seconds;
  const bool same = run.rms.values == densest.forced[kEach].rms.values;
  evaluation.findings.tables.push_back(
      {"5.6",
       absl::StrCat("To Each of ", densest.name, " with one worker and with ", workers),
       {"one worker (s)", absl::StrCat(workers, " workers (s)"), "speed-up", "same bytes"},
       {{Seconds(densest.forced[kEach].seconds), Seconds(run.seconds), FixedDecimal(speed_up, 2),
         same ? "yes" : "NO"}},
       "four threads: 22.9/57.2/188 s, speed-up 1.99/2.76/2.88"});
  evaluation.findings.Check("5.6", PropertyClass::kOrdinal, claim, "2.88 of 4",
                            absl::StrCat(FixedDecimal(speed_up, 2), " of ", workers,
                                         same ? ", same bytes" : ", OTHER BYTES"),
                            speed_up >= 0.7 * workers && same);
  return absl::OkStatus();
}

}  // namespace

std::string StrategyName(size_t strategy) {
  constexpr std::array<const char*, 3> kNames = {"To Each", "To One", "To Average"};
  return kNames[strategy];
}

absl::Status EvaluateSpeed(Evaluation& evaluation) {
  {
    COHORT_ASSIGN_OR_RETURN(const auto lab, Lab::Start(evaluation.data / "single", 1));
    COHORT_RETURN_IF_ERROR(RunAll(evaluation, *lab));
    AddTimes(evaluation);
    AddGrowth(evaluation);
    COHORT_RETURN_IF_ERROR(AddPasses(evaluation, *lab));
  }
  AddCounters(evaluation);
  return AddSpeedUp(evaluation);
}

}  // namespace cohort
