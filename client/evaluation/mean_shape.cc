#include <algorithm>
#include <cmath>
#include <optional>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/evaluation/evaluation.h"
#include "client/evaluation/shapes.h"
#include "client/job_frame.h"
#include "common/analysis/agreement.h"
#include "common/base/status_macros.h"
#include "common/report/decimal.h"
#include "common/report/render/shape_picture.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

constexpr int kPassesARound = 10;  ///< The thesis's I of To Average.
constexpr double kTolerance = 0.05;
constexpr size_t kOtherBase = 6;  ///< The thesis's figures 5.8 and 5.9: faces 1 and 7.

JobSpec AverageSpec(int rounds, const std::string& base) {
  JobSpec spec = ThesisSpec(Method::kAverage, kPassesARound * (rounds + 1), kTolerance, rounds);
  spec.base = base;
  return spec;
}

absl::StatusOr<TriangleMesh> ReferenceOf(Lab& lab, const Experiment& run) {
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(lab.GetSession(), lab.GetSession().Blobs(), run.job.id));
  return frame->LoadReference();
}

/// Figure 5.7: how many triads stay when another mesh is the base.
absl::Status AddBases(Evaluation& evaluation, Lab& lab) {
  const Density& density = evaluation.densities.front();
  if (evaluation.MeshCount() < int64_t{2} * kTriad) {
    evaluation.findings.NotTested("fig. 5.7", PropertyClass::kRange,
                                  "60 % of the triads stay when the base changes",
                                  "needs 6 meshes");
    return absl::OkStatus();
  }
  const Experiment& first = density.runs[kAverage];
  EvaluationTable table{"figure 5.7",
                        "triads that stay when another mesh is the base, " + density.name,
                        {"base", "same meshes", "same order too", "changed"},
                        {},
                        "273 of 380 the same"};
  int64_t same = 0;
  int64_t all = 0;
  for (size_t i = 1; i < density.files.size(); ++i) {
    const std::string& base = density.files[i].mesh.name;
    COHORT_ASSIGN_OR_RETURN(const Experiment run,
                            lab.Run(density.set, AverageSpec(3, base), Timing::kAnyTime));
    COHORT_ASSIGN_OR_RETURN(const NeighbourAgreement agree,
                            CompareNeighbours(first.rms, run.rms, kTriad));
    const int64_t kept = agree.correct + agree.wrong_order;
    same += kept;
    all += std::ssize(agree.rows);
    table.rows.push_back({base, absl::StrCat(kept), absl::StrCat(agree.correct),
                          absl::StrCat(std::ssize(agree.rows) - kept)});
  }
  evaluation.say(absl::StrCat(all, " triads of other bases, ", same, " the same"));
  evaluation.findings.tables.push_back(table);
  evaluation.findings.Check("fig. 5.7", PropertyClass::kRange,
                            "60 % of the triads stay when the base changes", "273 of 380 (72 %)",
                            absl::StrCat(same, " of ", all),
                            static_cast<double>(same) >= 0.6 * static_cast<double>(all));
  return absl::OkStatus();
}

/// Figures 5.8 and 5.9: mean shapes from two bases.
absl::Status AddTwoBases(Evaluation& evaluation, Lab& lab) {
  const Density& density = evaluation.Middle();
  Findings& findings = evaluation.findings;
  const std::string& other =
      density.files[std::min(kOtherBase, density.files.size() - 1)].mesh.name;
  std::vector<double> distances;
  std::optional<VariationMap> of_first;
  std::optional<VariationMap> of_other;
  for (const int rounds : {3, 5}) {
    COHORT_ASSIGN_OR_RETURN(const Experiment a,
                            lab.Run(density.set, AverageSpec(rounds, ""), Timing::kAnyTime));
    COHORT_ASSIGN_OR_RETURN(const Experiment b,
                            lab.Run(density.set, AverageSpec(rounds, other), Timing::kAnyTime));
    COHORT_ASSIGN_OR_RETURN(const TriangleMesh mean_a, ReferenceOf(lab, a));
    COHORT_ASSIGN_OR_RETURN(const TriangleMesh mean_b, ReferenceOf(lab, b));
    COHORT_ASSIGN_OR_RETURN(const TriangleMesh moved, MovedOnto(mean_b, mean_a));
    distances.push_back(ShapeDistance(moved, mean_a));
    if (rounds == 3) {
      COHORT_ASSIGN_OR_RETURN(of_first, FetchVariation(lab.GetSession(), a.job.id));
      COHORT_ASSIGN_OR_RETURN(of_other, FetchVariation(lab.GetSession(), b.job.id));
    }
  }
  findings.tables.push_back(
      {"figure 5.8",
       "mean shapes from the bases " + density.files.front().mesh.name + " and " + other +
           ", aligned",
       {"rounds", "RMS distance (mm)"},
       {{"3", FixedDecimal(distances[0], 4)}, {"5", FixedDecimal(distances[1], 4)}},
       "1.3701 at M = 3, 1.1517 at M = 5"});
  findings.Check("fig. 5.8", PropertyClass::kOrdinal,
                 "more rounds bring the mean shapes of two bases nearer", "1.3701, 1.1517",
                 absl::StrCat(FixedDecimal(distances[0], 4), ", ", FixedDecimal(distances[1], 4)),
                 distances[1] <= distances[0]);
  COHORT_ASSIGN_OR_RETURN(of_other->shape, MovedOnto(of_other->shape, of_first->shape));
  const std::vector<double> there = ValuesAt(*of_other, of_first->shape);
  const double correlation = RankCorrelation(of_first->rms, there);
  findings.Check("fig. 5.9", PropertyClass::kOrdinal,
                 "maps of variation from two bases show the same regions (rank correlation > 0.8)",
                 "nose, chin, cheeks",
                 absl::StrCat(FixedDecimal(correlation, 3), "; ",
                              FixedDecimal(100 * TopTenthOverlap(of_first->rms, there), 0),
                              " % of the most varying tenth in common"),
                 correlation > 0.8);
  for (const auto& [name, map] : {std::pair{"figure_5_9_first.png", &*of_first},
                                  std::pair{"figure_5_9_other.png", &*of_other}}) {
    ColorScale scale;
    scale.high = *std::max_element(of_first->rms.begin(), of_first->rms.end());
    COHORT_ASSIGN_OR_RETURN(
        std::string png,
        ShapeViewsPng(map->shape,
                      {.values = map->rms, .scale = scale, .title = "RMS", .unit = "mm"}, {}));
    findings.pictures.push_back({name, "Variation on the mean shape", std::move(png)});
  }
  return absl::OkStatus();
}

/// Figure 5.10: how far the mean shape moves from round to round.
absl::Status AddRounds(Evaluation& evaluation, Lab& lab) {
  constexpr int kMostRounds = 5;
  const Density& density = evaluation.Middle();
  std::vector<TriangleMesh> means;
  for (int rounds = 1; rounds <= kMostRounds; ++rounds) {
    COHORT_ASSIGN_OR_RETURN(const Experiment run,
                            lab.Run(density.set, AverageSpec(rounds, ""), Timing::kAnyTime));
    if (means.empty()) {
      COHORT_ASSIGN_OR_RETURN(const auto meshes, lab.GetSession().ListJobMeshes(run.job.id));
      COHORT_ASSIGN_OR_RETURN(const std::string base,
                              lab.GetSession().Blobs().Get(meshes.front().ingested->blob));
      COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, DecodeMeshBlob(base));
      means.push_back(std::move(mesh));
    }
    COHORT_ASSIGN_OR_RETURN(TriangleMesh mean, ReferenceOf(lab, run));
    means.push_back(std::move(mean));
  }
  EvaluationTable table{"figure 5.10",
                        "RMS distances of successive mean shapes, " + density.name,
                        {"from", "to", "RMS (mm)"},
                        {},
                        "base to mean 1 2.0212, mean 1 to 3 0.9569, mean 1 to 5 1.0475"};
  std::vector<double> steps;
  for (size_t i = 0; i + 1 < means.size(); ++i) {
    steps.push_back(ShapeDistance(means[i], means[i + 1]));
    table.rows.push_back({i == 0 ? "base" : absl::StrCat("mean ", i), absl::StrCat("mean ", i + 1),
                          FixedDecimal(steps.back(), 4)});
  }
  const double one_three = ShapeDistance(means[1], means[3]);
  const double one_five = ShapeDistance(means[1], means[5]);
  table.rows.push_back({"mean 1", "mean 3", FixedDecimal(one_three, 4)});
  table.rows.push_back({"mean 1", "mean 5", FixedDecimal(one_five, 4)});
  Findings& findings = evaluation.findings;
  findings.tables.push_back(table);
  findings.Check("fig. 5.10", PropertyClass::kOrdinal,
                 "the base is farther from mean 1 than that from mean 3", "2.0212 > 0.9569",
                 absl::StrCat(FixedDecimal(steps[0], 4), " and ", FixedDecimal(one_three, 4)),
                 steps[0] > one_three);
  findings.Check("fig. 5.10", PropertyClass::kOrdinal,
                 "each round moves the mean shape less than the one before", "so",
                 absl::StrJoin(steps, ", ",
                               [](std::string* out, double step) {
                                 absl::StrAppend(out, FixedDecimal(step, 4));
                               }),
                 std::is_sorted(steps.rbegin(), steps.rend()));
  findings.Check("5.6 of the text", PropertyClass::kOrdinal,
                 "the base matters more than rounds beyond 3", "1.37 against 0.09",
                 absl::StrCat("rounds 3 to 5 move the mean by ",
                              FixedDecimal(ShapeDistance(means[3], means[5]), 4), " mm"),
                 ShapeDistance(means[3], means[5]) < steps[0]);
  return absl::OkStatus();
}

/// Figure 5.5: maps of variation at several densities.
absl::Status AddDensities(Evaluation& evaluation, Lab& lab) {
  const std::string claim = "maps of variation at 10k and 20k are more alike than at 5k and 20k";
  if (evaluation.densities.size() < 3) {
    evaluation.findings.NotTested("fig. 5.5", PropertyClass::kRange, claim,
                                  "needs the set at three densities");
    return absl::OkStatus();
  }
  std::vector<VariationMap> maps;
  for (const Density& density : evaluation.densities) {
    COHORT_ASSIGN_OR_RETURN(VariationMap map,
                            FetchVariation(lab.GetSession(), density.runs[kAverage].job.id));
    if (!maps.empty()) {
      COHORT_ASSIGN_OR_RETURN(map.shape, MovedOnto(map.shape, maps.front().shape));
    }
    maps.push_back(std::move(map));
  }
  const VariationMap& densest = maps.back();
  const double sparse = RankCorrelation(densest.rms, ValuesAt(maps.front(), densest.shape));
  const double middle =
      RankCorrelation(densest.rms, ValuesAt(maps[maps.size() - 2], densest.shape));
  evaluation.findings.Check(
      "fig. 5.5", PropertyClass::kRange, claim, "10k and 20k alike, 5k not",
      absl::StrCat("rank correlations ", FixedDecimal(middle, 3), " and ", FixedDecimal(sparse, 3)),
      middle > sparse);
  return absl::OkStatus();
}

}  // namespace

absl::Status EvaluateMeanShape(Evaluation& evaluation, Lab& lab) {
  COHORT_RETURN_IF_ERROR(AddDensities(evaluation, lab));
  COHORT_RETURN_IF_ERROR(AddBases(evaluation, lab));
  COHORT_RETURN_IF_ERROR(AddTwoBases(evaluation, lab));
  return AddRounds(evaluation, lab);
}

}  // namespace cohort
