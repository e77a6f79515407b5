// `cohort evaluate`: chapter 5 of the thesis on the user's own meshes.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/evaluation/evaluation.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/job_frame.h"
#include "client/labels_csv.h"
#include "client/output/exit_codes.h"
#include "common/base/process.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/base/version.h"
#include "common/report/job_meshes.h"

namespace cohort {
namespace {

struct EvaluateFlags {
  std::vector<std::string> folders;
  std::string labels;
  std::string person_before;
  std::string out;
  bool json = false;
};

/// The person of each file whose name has the separator: what stands before its last one.
void LabelByName(const std::string& separator, std::vector<MeshFile>& files) {
  for (MeshFile& file : files) {
    const size_t end = file.mesh.name.rfind(separator);
    if (end != std::string::npos && end > 0) {
      file.mesh.labels[std::string(kPersonLabel)] = file.mesh.name.substr(0, end);
    }
  }
}

absl::StatusOr<Density> ReadDensity(const EvaluateFlags& flags,
                                    const std::string& folder,
                                    const Labels& labels) {
  COHORT_ASSIGN_OR_RETURN(const auto paths, ListMeshFiles(folder));
  if (paths.size() < 3) {
    return absl::FailedPreconditionError(
        absl::StrCat("folder ", folder, " has ", paths.size(), " meshes; an evaluation needs 3"));
  }
  Density density;
  const std::filesystem::path path = std::filesystem::weakly_canonical(folder);
  density.name = path.filename().string();
  COHORT_ASSIGN_OR_RETURN(density.files, DescribeFiles(paths, labels));
  if (!flags.person_before.empty()) {
    LabelByName(flags.person_before, density.files);
  }
  return density;
}

std::vector<std::string> NamesOf(const Density& density) {
  std::vector<std::string> names;
  for (const MeshFile& file : density.files) {
    names.push_back(std::filesystem::path(file.mesh.name).stem().string());
  }
  return names;
}

absl::StatusOr<std::vector<Density>> ReadDensities(const EvaluateFlags& flags) {
  Labels labels;
  if (!flags.labels.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(flags.labels));
    COHORT_ASSIGN_OR_RETURN(labels, ParseLabels(text, flags.labels));
  }
  std::vector<Density> densities;
  for (const std::string& folder : flags.folders) {
    COHORT_ASSIGN_OR_RETURN(Density density, ReadDensity(flags, folder, labels));
    density.set = absl::StrCat("density-", densities.size() + 1);
    if (!densities.empty() && NamesOf(density) != NamesOf(densities.front())) {
      return absl::InvalidArgumentError(
          absl::StrCat("folders ", flags.folders.front(), " and ", folder,
                       " have other meshes; an evaluation takes one set, or the same meshes (by "
                       "name) at several densities"));
    }
    densities.push_back(std::move(density));
  }
  return densities;
}

/// Two meshes of one person, and two persons.
bool HasPersons(const Density& density) {
  std::multiset<std::string> persons;
  for (const MeshFile& file : density.files) {
    const auto found = file.mesh.labels.find(std::string(kPersonLabel));
    if (found != file.mesh.labels.end()) persons.insert(found->second);
  }
  return std::any_of(persons.begin(), persons.end(), [&](const std::string& person) {
    return persons.count(person) > 1 && persons.count(person) < persons.size();
  });
}

std::string Heading(const Evaluation& evaluation) {
  std::string heading = absl::StrCat(
      "# Evaluation of ", evaluation.MeshCount(), " meshes\n\n", "By cohort ",
      std::string(BuildVersion()),
      ", with the protocol of the thesis \"Comparison and "
      "Analysis of Multiple 3D Shapes\" (chapter 5): To Each and To One at most 40 iterations, To "
      "Average 10 a round and 3 rounds, e = 0.05 mm, least-squares scale, RMS of the distances, "
      "mean "
      "of both directions, plain ICP. Times are of one thread unless said.\n\n");
  for (const Density& density : evaluation.densities) {
    absl::StrAppend(&heading, "- ", density.name, ": ", std::llround(density.vertices),
                    " vertices a mesh\n");
  }
  return heading;
}

absl::Status WriteFindings(const Evaluation& evaluation, const std::filesystem::path& folder) {
  FolderWriter out(folder);
  const Findings& findings = evaluation.findings;
  for (const EvaluationTable& table : findings.tables) {
    const std::string name =
        "table_" + absl::StrReplaceAll(table.item, {{".", "_"}, {" ", "_"}}) + ".csv";
    COHORT_RETURN_IF_ERROR(out.Write({name, table.title, ""}, TableCsv(table)));
  }
  for (const EvaluationPicture& picture : findings.pictures) {
    COHORT_RETURN_IF_ERROR(out.Write({picture.name, picture.description, ""}, picture.png));
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"verdicts.csv", "every property of the thesis", ""}, PropertiesCsv(findings)));
  return out.Write({"evaluation.md", "verdicts and all tables", ""},
                   FindingsMarkdown(findings, Heading(evaluation)));
}

nlohmann::json ToJson(const Findings& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Property& property : findings.properties) {
    list.push_back({{"item", property.item},
                    {"class", std::string(1, ClassLetter(property.kind))},
                    {"claim", property.claim},
                    {"thesis", property.thesis},
                    {"here", property.seen},
                    {"verdict", VerdictText(property.verdict)}});
  }
  return {{"properties", list}, {"failures", CountFailures(findings)}};
}

std::string ToText(const Findings& findings, const std::string& folder) {
  std::string text;
  int holding = 0;
  int untested = 0;
  for (const Property& property : findings.properties) {
    holding += property.verdict == Verdict::kHolds ? 1 : 0;
    untested += property.verdict == Verdict::kNotTested ? 1 : 0;
    if (property.verdict == Verdict::kFails) {
      absl::StrAppend(&text, "  ", property.item, " (", std::string(1, ClassLetter(property.kind)),
                      "): ", property.claim, "\n    thesis: ", property.thesis,
                      "; here: ", property.seen, "\n");
    }
  }
  const auto all = std::ssize(findings.properties);
  return absl::StrCat(holding, " of ", all, " properties of the thesis hold, ", untested,
                      " could not be tested", text.empty() ? "" : "; these do not hold:", "\n",
                      text, "  ", (std::filesystem::path(folder) / "evaluation.md").string(), "\n");
}

absl::StatusOr<int> RunEvaluate(const EvaluateFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(std::vector<Density> densities, ReadDensities(flags));
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  const std::filesystem::path data = std::filesystem::path(flags.out) / ".cohort-data";
  std::error_code ignored;
  std::filesystem::remove_all(data, ignored);  // Of a run that was interrupted.
  COHORT_RETURN_IF_ERROR(PrepareFolder(data / "single"));
  COHORT_RETURN_IF_ERROR(PrepareFolder(data / "parallel"));
  ThreadPool threads(LocalThreads());
  Evaluation evaluation{.data = data,
                        .densities = std::move(densities),
                        .has_persons = false,
                        .executor = threads,
                        .say = [](const std::string& line) { std::cerr << line << "\n"; },
                        .findings = {}};
  evaluation.has_persons = HasPersons(evaluation.densities.front());
  COHORT_RETURN_IF_ERROR(EvaluateSpeed(evaluation));
  {
    COHORT_ASSIGN_OR_RETURN(const auto lab, Lab::Start(data / "single", LocalThreads()));
    COHORT_RETURN_IF_ERROR(EvaluateNeighbours(evaluation, *lab));
    COHORT_RETURN_IF_ERROR(EvaluateMeanShape(evaluation, *lab));
    COHORT_RETURN_IF_ERROR(EvaluateAccuracy(evaluation, *lab));
  }
  COHORT_RETURN_IF_ERROR(WriteFindings(evaluation, flags.out));
  std::filesystem::remove_all(data, ignored);  // Left behind, it only takes space.
  std::cout << (flags.json ? ToJson(evaluation.findings).dump(2) + "\n"
                           : ToText(evaluation.findings, flags.out));
  return kExitOk;
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "evaluate", "every table of chapter 5 of the thesis on your own meshes, and what holds");
  const auto flags = std::make_shared<EvaluateFlags>();
  command
      ->add_option("folders", flags->folders,
                   "folder of meshes; or several of the same meshes (by name) at other densities")
      ->required();
  command->add_option("--out", flags->out, "folder for evaluation.md, tables and pictures")
      ->required();
  command->add_option("--labels", flags->labels, "CSV with columns file and person");
  command->add_option(
      "--person-before", flags->person_before,
      "the person is what stands in a file's name before the last of these, e.g. _");
  command->add_flag("--json", flags->json, "print the verdicts as JSON");
  command->callback([flags, &action] { action = [flags] { return RunEvaluate(*flags); }; });
  command->footer(
      "Runs To Each, To One and To Average many times on this machine (a minute or so for 20 "
      "meshes\n"
      "of 5,000, 10,000 and 20,000 vertices). The exit code is 0 also if a property does not "
      "hold.\n"
      "Example: cohort evaluate faces_5k faces_10k faces_20k --person-before _ --out evaluation");
}

}  // namespace cohort
