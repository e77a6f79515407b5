// `cohort analyze`: the statistics of a matrix, from a results folder, a matrix file or a server.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <thread>
#include <utility>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "client/analysis.h"
#include "client/analysis_input.h"
#include "client/analysis_meshes.h"
#include "client/commands/analysis_flags.h"
#include "client/commands/command.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/output/analysis_text.h"
#include "client/output/exit_codes.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"
#include "common/base/version.h"
#include "common/report/csv.h"
#include "common/report/statistics_csv.h"

namespace cohort {
namespace {

struct AnalyzeFlags {
  ServerFlags server;
  MatrixFlags matrix;
  std::string source;
  std::string labels;
  std::string pattern;
  std::string linkage = "average";
  std::string out;
  AnalysisOptions options;
};

absl::StatusOr<AnalysisOptions> ToOptions(const AnalyzeFlags& flags) {
  AnalysisOptions options = flags.options;
  const std::optional<Linkage> linkage = LinkageFromName(flags.linkage);
  if (!linkage) {
    return absl::InvalidArgumentError("--linkage " + flags.linkage +
                                      ": expected average, complete, single or ward");
  }
  options.linkage = *linkage;
  COHORT_RETURN_IF_ERROR(options.Validate());
  return options;
}

absl::Status WriteClusters(const AnalysisInput& input,
                           const Analysis& analysis,
                           FolderWriter& out) {
  const std::vector<std::string>& labels = analysis.complete.labels;
  COHORT_RETURN_IF_ERROR(
      out.Write({"clusters.csv", "place of each mesh along the dendrogram, its cluster", ""},
                ClustersCsv(labels, analysis.dendrogram, analysis.clusters)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"merges.csv", "merges of the dendrogram, numbered as scipy's linkage", input.unit},
                MergesCsv(analysis.dendrogram)));
  return out.Write({"dendrogram.newick", "the dendrogram for R's ape, FigTree, iTOL", input.unit},
                   NewickText(analysis.dendrogram, labels));
}

absl::Status WriteGroups(const AnalysisInput& input,
                         const AnalysisOptions& options,
                         const Analysis& analysis,
                         FolderWriter& out) {
  if (!analysis.groups || !analysis.permanova) {
    out.LeaveOut("groups.csv");
    out.LeaveOut("permanova.csv");
    return absl::OkStatus();
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"groups.csv", "distances within and between the groups", input.unit},
                GroupsCsv(*analysis.groups)));
  return out.Write({"permanova.csv", "do the groups differ? analysis of variance of distances", ""},
                   PermanovaCsv(*analysis.permanova, options.by));
}

absl::Status WritePersons(const AnalysisInput& input, const Analysis& analysis, FolderWriter& out) {
  if (!analysis.identification) {
    for (const char* name : {"identification.csv", "cmc.csv", "roc.csv", "scores_genuine.txt",
                             "scores_impostor.txt"}) {
      out.LeaveOut(name);
    }
    return absl::OkStatus();
  }
  const PersonAnalysis& persons = *analysis.identification;
  std::optional<Identification> other_sessions;
  if (analysis.other_sessions) {
    other_sessions = analysis.other_sessions->identification;
  }
  COHORT_RETURN_IF_ERROR(out.Write(
      {"identification.csv", "each mesh sought among the others: rank of the person", input.unit},
      IdentificationCsv(input.matrix.labels, analysis.persons, persons.identification)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"cmc.csv", "share of searches with the person among the k nearest", ""},
                CmcCsv(persons.identification, other_sessions)));
  if (persons.verification) {
    COHORT_RETURN_IF_ERROR(
        out.Write({"roc.csv", "false accepts and rejects by threshold", input.unit},
                  RocCsv(*persons.verification)));
  } else {
    out.LeaveOut("roc.csv");
  }
  COHORT_RETURN_IF_ERROR(
      out.Write({"scores_genuine.txt", "distances of pairs of one person", input.unit},
                ScoresText(persons.scores.genuine)));
  return out.Write({"scores_impostor.txt", "distances of pairs of two people", input.unit},
                   ScoresText(persons.scores.impostor));
}

absl::Status WriteAll(const AnalysisInput& input,
                      const AnalysisOptions& options,
                      const Analysis& analysis,
                      FolderWriter& out) {
  COHORT_RETURN_IF_ERROR(
      out.Write({"neighbours.csv", "the most similar meshes of each mesh", input.unit},
                NeighboursCsv(input.matrix, analysis.neighbours, analysis.persons)));
  COHORT_RETURN_IF_ERROR(WriteClusters(input, analysis, out));
  COHORT_RETURN_IF_ERROR(out.Write({"pcoa.csv", "principal coordinates of the meshes", input.unit},
                                   PcoaCsv(analysis.complete.labels, analysis.ordination)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"pcoa_eigenvalues.csv", "eigenvalues, and what the axes explain", ""},
                EigenvaluesCsv(analysis.ordination)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"outliers.csv", "mean distance and residual of each mesh, robust z", input.unit},
                OutliersCsv(input.matrix.labels, analysis.outliers)));
  COHORT_RETURN_IF_ERROR(WriteGroups(input, options, analysis, out));
  return WritePersons(input, analysis, out);
}

/// Files of an analysis must not take the place of a job's (neighbours.csv is of both).
absl::Status CheckOut(const std::string& out) {
  if (std::filesystem::exists(std::filesystem::path(out) / "matrix.csv") ||
      std::filesystem::exists(std::filesystem::path(out) / "matrix.npy")) {
    return absl::InvalidArgumentError("--out " + out +
                                      ": is a results folder; give the analysis one of its own");
  }
  return PrepareFolder(out);
}

absl::StatusOr<int> Analyze(const AnalyzeFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const AnalysisOptions options, ToOptions(flags));
  COHORT_ASSIGN_OR_RETURN(const AnalysisSource source,
                          flags.matrix.ToSource(flags.source, flags.server.server));
  COHORT_ASSIGN_OR_RETURN(AnalysisInput input, ReadAnalysisInput(source));
  if (!flags.labels.empty()) {
    COHORT_RETURN_IF_ERROR(ReplaceLabels(flags.labels, input));
  }
  if (!flags.pattern.empty()) {
    COHORT_RETURN_IF_ERROR(LabelByName(flags.pattern, input));
  }
  ThreadPool threads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  COHORT_ASSIGN_OR_RETURN(const Analysis analysis, AnalyzeMatrix(input, options, threads));
  nlohmann::ordered_json json = AnalysisToJson(input, options, analysis);
  std::string text = AnalysisToText(input, options, analysis);
  if (!flags.out.empty()) {
    COHORT_RETURN_IF_ERROR(CheckOut(flags.out));
    FolderWriter out(flags.out);
    COHORT_RETURN_IF_ERROR(WriteAll(input, options, analysis, out));
    json["software"] = "cohort " + std::string(BuildVersion());
    json["files"] = nlohmann::ordered_json::array();
    for (const ResultFile& file : out.Files()) {
      json["files"].push_back(
          {{"name", file.name}, {"description", file.description}, {"unit", file.unit}});
    }
    // Last, so that a folder with an analysis.json is a whole one.
    COHORT_RETURN_IF_ERROR(out.Write({"analysis.json", "", ""}, AsText(json)));
    absl::StrAppend(&text, "files are in ", flags.out, ": clusters.csv, pcoa.csv, outliers.csv, ",
                    "analysis.json, ...\n");
  }
  std::cout << (flags.server.json ? AsText(json) : text);
  return kExitOk;
}

void AddOptions(CLI::App& command, AnalyzeFlags& flags) {
  AnalysisOptions& options = flags.options;
  command
      .add_option("source", flags.source,
                  "results folder, matrix file (.csv, or .npy with labels.txt beside it), or "
                  "the id of a job on the server")
      ->required();
  flags.matrix.AddTo(command);
  command.add_option("--labels", flags.labels,
                     "CSV of labels with a column 'file'; goes before those of the job");
  command.add_option("--pattern", flags.pattern,
                     "labels in the names of the files, e.g. {person}_{session}");
  command.add_option("--by", options.by,
                     "label column of the groups to compare (groups.csv, permanova.csv)");
  command.add_option("--person", options.person, "label column that says whose mesh it is")
      ->capture_default_str();
  command
      .add_option("--session", options.session,
                  "label column of sessions: each is left out in turn")
      ->capture_default_str();
  command.add_option("--threshold", options.threshold,
                     "tell false accepts and rejects at this distance");
  command.add_option("--linkage", flags.linkage, "average, complete, single or ward")
      ->capture_default_str();
  command.add_option("--clusters", options.clusters, "cut the dendrogram into so many clusters");
  command.add_option("--neighbours", options.neighbours, "most similar meshes to list of each")
      ->capture_default_str();
  command.add_option("--axes", options.axes, "axes of the ordination (pcoa.csv)")
      ->capture_default_str();
  command.add_option("--permutations", options.permutations, "of the PERMANOVA")
      ->capture_default_str();
  command.add_option("--seed", options.seed, "of the permutations")->capture_default_str();
  command.add_option("--out", flags.out, "folder for the tables; made if new");
}

}  // namespace

void AddAnalyzeCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "analyze", "statistics of a matrix: clusters, ordination, groups, outliers, identification");
  const auto flags = std::make_shared<AnalyzeFlags>();
  flags->server.AddTo(*command);
  AddOptions(*command, *flags);
  command->footer(
      "Nothing is computed anew: the matrix is all it needs. The same input and seed give the same "
      "bytes.\n"
      "Examples:\n"
      "  cohort analyze results --by sex --out statistics\n"
      "  cohort analyze j-000001 --metric p75 --labels people.csv --linkage ward --clusters 4\n"
      "  cohort analyze distances_from_r.csv --pattern {person}_{session} --json");
  command->callback([flags, &action] { action = [flags] { return Analyze(*flags); }; });
}

}  // namespace cohort
