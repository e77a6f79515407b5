// `cohort mantel`: do two matrices over the same meshes go together?
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/analysis_input.h"
#include "client/analysis_meshes.h"
#include "client/commands/analysis_flags.h"
#include "client/commands/command.h"
#include "client/output/exit_codes.h"
#include "common/analysis/agreement.h"
#include "common/analysis/distances.h"
#include "common/analysis/mantel.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/report/decimal.h"

namespace cohort {
namespace {

using Json = nlohmann::ordered_json;

struct MantelFlags {
  ServerFlags server;
  MatrixFlags matrix;
  std::string a;
  std::string b;
  std::string partial;
  std::string closer_to;
  bool spearman = false;
  bool two_sided = false;
  bool common = false;
  int neighbours = 3;
  MantelOptions options;
};

/// The matrices over the same meshes, in this order: a, b, those that were given of partial and
/// closer_to.
struct Matched {
  std::vector<AnalysisInput> inputs;
  std::vector<std::string> left_out;  ///< Meshes with missing pairs in one of them.
};

struct Answer {
  MantelResult mantel;
  int neighbours = 0;
  NeighbourAgreement agreement;
  std::optional<Closeness> closeness;
};

absl::StatusOr<Matched> ReadAndMatch(const MantelFlags& flags) {
  Matched matched;
  for (const std::string& name : {flags.a, flags.b, flags.partial, flags.closer_to}) {
    if (!name.empty()) {
      COHORT_ASSIGN_OR_RETURN(const AnalysisSource source,
                              flags.matrix.ToSource(name, flags.server.server));
      COHORT_ASSIGN_OR_RETURN(AnalysisInput input, ReadAnalysisInput(source));
      matched.inputs.push_back(std::move(input));
    }
  }
  COHORT_RETURN_IF_ERROR(
      MatchMeshes(matched.inputs, flags.common ? OtherMeshes::kLeaveOut : OtherMeshes::kRefuse));
  // A pair that misses in one matrix misses in the sum.
  MetricMatrix sum = matched.inputs.front().matrix;
  for (size_t i = 1; i < matched.inputs.size(); ++i) {
    sum.values += matched.inputs[i].matrix.values;
  }
  const std::vector<int64_t> complete = CompleteMeshes(sum);
  const MetricMatrix kept = PartOf(sum, complete);
  if (kept.labels.size() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(kept.labels.size(),
                     " meshes have no missing pairs in all matrices, at least 3 are needed"));
  }
  for (const std::string& mesh : sum.labels) {
    if (std::find(kept.labels.begin(), kept.labels.end(), mesh) == kept.labels.end()) {
      matched.left_out.push_back(mesh);
    }
  }
  for (AnalysisInput& input : matched.inputs) {
    input.matrix = PartOf(input.matrix, complete);
  }
  return matched;
}

/// Which matrix is constant is what its name says, not the statistic.
absl::Status NamedConstant(const std::vector<AnalysisInput>& inputs, const absl::Status& status) {
  for (const AnalysisInput& input : inputs) {
    const std::vector<double> values = LowerTriangle(input.matrix.values);
    if (std::all_of(values.begin(), values.end(),
                    [&](double value) { return value == values.front(); })) {
      return absl::Status(status.code(),
                          absl::StrCat(input.source, ": ", std::string(status.message())));
    }
  }
  return status;
}

absl::StatusOr<Answer> Test(const MantelFlags& flags, const Matched& matched) {
  MantelOptions options = flags.options;
  options.correlation = flags.spearman ? Correlation::kSpearman : Correlation::kPearson;
  options.alternative = flags.two_sided ? Alternative::kTwoSided : Alternative::kGreater;
  ThreadPool threads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  const MetricMatrix& a = matched.inputs[0].matrix;
  const MetricMatrix& b = matched.inputs[1].matrix;
  const absl::StatusOr<MantelResult> mantel =
      flags.partial.empty() ? MantelTest(a, b, options, threads)
                            : PartialMantelTest(a, b, matched.inputs[2].matrix, options, threads);
  if (!mantel.ok()) {
    return NamedConstant(matched.inputs, mantel.status());
  }
  Answer answer;
  answer.mantel = *mantel;
  // Three meshes have two neighbours each, whatever was asked for.
  answer.neighbours = std::min(flags.neighbours, static_cast<int>(a.labels.size()) - 1);
  COHORT_ASSIGN_OR_RETURN(answer.agreement, CompareNeighbours(a, b, answer.neighbours));
  if (!flags.closer_to.empty()) {
    COHORT_ASSIGN_OR_RETURN(answer.closeness, CompareCloseness(a, b, matched.inputs.back().matrix));
  }
  return answer;
}

std::string AgreementText(const Answer& answer) {
  const NeighbourAgreement& agreement = answer.agreement;
  std::string missed;
  for (size_t m = 0; m < agreement.missed.size(); ++m) {
    missed += fmt::format("{} {}: {}", m == 0 ? ", missed" : ",", m + 1, agreement.missed[m]);
  }
  return fmt::format(
      "{} nearest of each in both: {} of {}; same order: {}, other order: {}{}\n"
      "nearest mesh is the same: {} of {}\n",
      answer.neighbours, agreement.kept, agreement.wanted, agreement.correct, agreement.wrong_order,
      missed, agreement.same_nearest, agreement.rows.size());
}

std::string Text(const MantelFlags& flags, const Matched& matched, const Answer& answer) {
  const MantelResult& mantel = answer.mantel;
  std::string text = fmt::format(
      "Mantel {} r = {}, p = {} ({}, {} permutations, seed {}, {} meshes)\n",
      flags.spearman ? "Spearman" : "Pearson", FixedDecimal(mantel.r, 4),
      ReadableDecimal(mantel.p, 3), flags.two_sided ? "two-sided" : "one-sided, greater",
      mantel.permutations, flags.options.seed, mantel.meshes);
  if (!flags.partial.empty()) {
    text = "partial " + text + "  given " + flags.partial + "\n";
  }
  text += AgreementText(answer);
  if (answer.closeness) {
    const Closeness& cells = *answer.closeness;
    text += fmt::format("closer to {}: {} cells of {}, {} of {}, {} equal (with the diagonal)\n",
                        flags.closer_to, cells.first, flags.a, cells.second, flags.b, cells.equal);
  }
  if (!matched.left_out.empty()) {
    text += "note: left out, as pairs of theirs are missing: " + SomeOf(matched.left_out) + "\n";
  }
  for (const AnalysisInput& input : matched.inputs) {
    for (const std::string& note : input.notes) {
      text += "note: " + input.source + ": " + note + "\n";
    }
  }
  return text;
}

Json AsJson(const MantelFlags& flags, const Matched& matched, const Answer& answer) {
  const NeighbourAgreement& agreement = answer.agreement;
  Json json = {{"a", flags.a},
               {"b", flags.b},
               {"given", flags.partial.empty() ? Json() : Json(flags.partial)},
               {"meshes", answer.mantel.meshes},
               {"left_out", matched.left_out},
               {"correlation", flags.spearman ? "spearman" : "pearson"},
               {"alternative", flags.two_sided ? "two-sided" : "greater"},
               {"r", answer.mantel.r},
               {"p", answer.mantel.p},
               {"as_extreme", answer.mantel.as_extreme},
               {"permutations", answer.mantel.permutations},
               {"seed", flags.options.seed}};
  json["neighbours"] = {{"k", answer.neighbours},
                        {"same_order", agreement.correct},
                        {"other_order", agreement.wrong_order},
                        {"missed", agreement.missed},
                        {"kept", agreement.kept},
                        {"wanted", agreement.wanted},
                        {"same_nearest", agreement.same_nearest},
                        {"nearest_kept", agreement.nearest_kept}};
  json["closer"] = nullptr;
  if (answer.closeness) {
    json["closer"] = {{"to", flags.closer_to},
                      {"a", answer.closeness->first},
                      {"b", answer.closeness->second},
                      {"equal", answer.closeness->equal}};
  }
  json["notes"] = Json::array();
  for (const AnalysisInput& input : matched.inputs) {
    for (const std::string& note : input.notes) {
      json["notes"].push_back(input.source + ": " + note);
    }
  }
  return json;
}

absl::StatusOr<int> Mantel(const MantelFlags& flags) {
  COHORT_RETURN_IF_ERROR(flags.options.Validate());
  if (flags.neighbours < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("--neighbours ", flags.neighbours, ": expected 1 or more"));
  }
  COHORT_ASSIGN_OR_RETURN(const Matched matched, ReadAndMatch(flags));
  COHORT_ASSIGN_OR_RETURN(const Answer answer, Test(flags, matched));
  std::cout << (flags.server.json ? AsText(AsJson(flags, matched, answer))
                                  : Text(flags, matched, answer));
  return kExitOk;
}

void AddOptions(CLI::App& command, MantelFlags& flags) {
  const std::string what = "results folder, matrix file or id of a job";
  command.add_option("a", flags.a, what)->required();
  command.add_option("b", flags.b, what + ", over the same meshes")->required();
  command.add_option("--partial", flags.partial,
                     "a third matrix: what both owe to it is taken out (partial Mantel test)");
  command.add_option("--closer-to", flags.closer_to,
                     "a third matrix: count the cells of a and of b that are closer to it");
  command.add_flag("--spearman", flags.spearman, "correlate ranks instead of values");
  command.add_flag("--two-sided", flags.two_sided,
                   "count permutations as far from zero; otherwise those as large");
  command.add_flag("--common", flags.common, "take the meshes that all matrices have");
  command.add_option("--neighbours", flags.neighbours, "nearest meshes whose agreement is told")
      ->capture_default_str();
  command.add_option("--permutations", flags.options.permutations, "random orders of the meshes")
      ->capture_default_str();
  command.add_option("--seed", flags.options.seed, "of the permutations")->capture_default_str();
  flags.matrix.AddTo(command);
}

}  // namespace

void AddMantelCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "mantel", "do two matrices over the same meshes go together? (Mantel test, neighbours)");
  const auto flags = std::make_shared<MantelFlags>();
  flags->server.AddTo(*command);
  AddOptions(*command, *flags);
  command->footer(
      "p = (1 + permutations as extreme) / (1 + permutations). Meshes are matched by name.\n"
      "Examples:\n"
      "  cohort mantel one average --permutations 9999\n"
      "  cohort mantel shape form --partial ages.csv --spearman\n"
      "  cohort mantel j-000001 j-000002 --common --json");
  command->callback([flags, &action] { action = [flags] { return Mantel(*flags); }; });
}

}  // namespace cohort
