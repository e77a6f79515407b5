// `cohort gpa`: generalised Procrustes analysis of landmarks, without meshes and without a server.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/folder_writer.h"
#include "client/landmark_files.h"
#include "client/output/exit_codes.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/geometry/io/landmarks.h"
#include "common/report/csv.h"
#include "common/report/gpa_report.h"
#include "common/report/heatmap.h"
#include "common/report/npy.h"

namespace cohort {
namespace {

constexpr size_t kNamed = 5;

struct GpaFlags {
  std::vector<std::string> paths;
  std::string out;
  std::string size = "normalized";
  std::string variant = "exact";
  bool json = false;
};

absl::StatusOr<ProcrustesOptions> ToOptions(const GpaFlags& flags) {
  ProcrustesOptions options;
  if (flags.size != "normalized" && flags.size != "kept") {
    return absl::InvalidArgumentError("--size " + flags.size + ": expected normalized or kept");
  }
  options.size = flags.size == "kept" ? ProcrustesSize::kKept : ProcrustesSize::kNormalized;
  if (flags.variant != "exact" && flags.variant != "fidentis") {
    return absl::InvalidArgumentError("--variant " + flags.variant +
                                      ": expected exact or fidentis");
  }
  options.variant = flags.variant == "exact" ? ProcrustesOptions::Variant::kExact
                                             : ProcrustesOptions::Variant::kFidentis;
  return options;
}

std::string NameOf(const ReadLandmarkSet& set) {
  return set.mesh.empty() ? set.file : set.mesh;
}

/// By name, so that the order of the files does not matter.
absl::Status SortByName(std::vector<ReadLandmarkSet>& sets) {
  std::sort(sets.begin(), sets.end(), [](const ReadLandmarkSet& a, const ReadLandmarkSet& b) {
    return NameOf(a) < NameOf(b);
  });
  for (size_t i = 1; i < sets.size(); ++i) {
    if (NameOf(sets[i - 1]) == NameOf(sets[i])) {
      return absl::InvalidArgumentError(absl::StrCat("landmarks of ", NameOf(sets[i]),
                                                     " are there twice: in ", sets[i - 1].path,
                                                     " and ", sets[i].path));
    }
  }
  if (sets.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("a Procrustes analysis needs two landmark sets, ",
                     sets.empty() ? "there is none" : "there is one: ",
                     sets.empty() ? "" : NameOf(sets.front())));
  }
  return absl::OkStatus();
}

std::vector<std::string> NamesLeftOut(const std::vector<ReadLandmarkSet>& sets,
                                      const std::vector<std::string>& common) {
  std::set<std::string> names;
  for (const ReadLandmarkSet& set : sets) {
    names.insert(set.landmarks.names.begin(), set.landmarks.names.end());
  }
  for (const std::string& name : common) {
    names.erase(name);
  }
  return {names.begin(), names.end()};
}

/// The error of an analysis, with the sets that are at fault by name.
absl::Status Explained(const absl::Status& status,
                       const std::vector<ReadLandmarkSet>& sets,
                       const std::vector<LandmarkSet>& landmarks,
                       const ProcrustesOptions& options) {
  const std::vector<std::string> common = CommonLandmarks(landmarks);
  if (common.size() < 3) {
    const auto fewest = std::min_element(sets.begin(), sets.end(),
                                         [](const ReadLandmarkSet& a, const ReadLandmarkSet& b) {
                                           return a.landmarks.Count() < b.landmarks.Count();
                                         });
    return absl::InvalidArgumentError(absl::StrCat(
        std::string(status.message()), "; ", NameOf(*fewest), " has ", fewest->landmarks.Count(),
        fewest->landmarks.names.size() <= kNamed
            ? absl::StrCat(" (", absl::StrJoin(fewest->landmarks.names, ", "), ")")
            : ""));
  }
  for (size_t s = 0; s < sets.size(); ++s) {
    const LandmarkSet alone = {common, PointsOf(landmarks[s], common)};
    if (!AnalyzeProcrustes(std::span(&alone, 1), options).ok()) {
      return absl::Status(status.code(), absl::StrCat(sets[s].path, ": the common landmarks of ",
                                                      NameOf(sets[s]), " coincide"));
    }
  }
  return status;
}

absl::StatusOr<GpaReport> Analyze(const std::vector<ReadLandmarkSet>& sets,
                                  const ProcrustesOptions& options) {
  GpaReport report;
  report.options = options;
  std::vector<LandmarkSet> landmarks;
  for (const ReadLandmarkSet& set : sets) {
    report.sets.push_back(
        {.name = NameOf(set), .file = set.file, .landmarks = set.landmarks.Count()});
    landmarks.push_back(set.landmarks);
  }
  absl::StatusOr<ProcrustesAnalysis> analysis = AnalyzeProcrustes(landmarks, options);
  if (!analysis.ok()) {
    return Explained(analysis.status(), sets, landmarks, options);
  }
  report.analysis = *std::move(analysis);
  report.left_out = NamesLeftOut(sets, report.analysis.names);
  return report;
}

std::string AlignedCsv(const GpaReport& report) {
  std::vector<MeshLandmarks> aligned;
  for (size_t s = 0; s < report.sets.size(); ++s) {
    aligned.push_back({.mesh = report.sets[s].name,
                       .landmarks = {report.analysis.names, report.analysis.aligned[s]}});
  }
  return WriteLandmarkTableCsv(aligned);
}

absl::Status WriteFiles(const GpaReport& report,
                        const std::vector<GpaInput>& inputs,
                        FolderWriter& out) {
  const MetricMatrix matrix = GpaMatrix(report);
  const MatrixDescription description = DescribeGpa(report);
  const std::string& unit = description.unit;
  COHORT_RETURN_IF_ERROR(out.Write({"matrix.csv", "Procrustes distance of every pair", unit},
                                   MatrixCsv(matrix, "procrustes_distance")));
  COHORT_RETURN_IF_ERROR(
      out.Write({"matrix.npy", "matrix.csv for NumPy", unit}, MatrixNpy(matrix.values)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"labels.txt", "names of the rows of matrix.npy", ""}, LabelsText(matrix.labels)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"consensus.csv", "the mean of the superimposed sets, a landmark file", unit},
                WriteLandmarksCsv({report.analysis.names, report.analysis.consensus})));
  COHORT_RETURN_IF_ERROR(out.Write(
      {"aligned.csv", "all sets as superimposed, a landmark file", unit}, AlignedCsv(report)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"sets.csv", "centroid size (as read) and distance to the mean of each set", ""},
                GpaSetsCsv(report)));
  COHORT_RETURN_IF_ERROR(
      out.Write({"heatmap.png", "the matrix as a picture", unit}, HeatmapPng(matrix, description)));
  return out.Write({"job.json", "parameters, inputs, versions", ""},
                   GpaJson(report, inputs, out.Files(), "cohort " + std::string(BuildVersion())));
}

/// All files that were read, by name.
absl::StatusOr<std::vector<GpaInput>> HashInputs(const std::vector<std::string>& paths) {
  COHORT_ASSIGN_OR_RETURN(const auto files, ExpandLandmarkPaths(paths));
  std::vector<GpaInput> inputs;
  for (const std::filesystem::path& file : files) {
    COHORT_ASSIGN_OR_RETURN(const FileDigest hashed, HashFile(file));
    inputs.push_back({.name = file.filename().string(), .sha256 = hashed.digest});
  }
  std::sort(inputs.begin(), inputs.end(), [](const GpaInput& a, const GpaInput& b) {
    return std::pair(a.name, a.sha256) < std::pair(b.name, b.sha256);
  });
  return inputs;
}

std::string Text(const GpaReport& report, const std::string& folder) {
  std::string text = absl::StrCat(report.sets.size(), " sets, ", report.analysis.names.size(),
                                  " landmarks in common, ", report.analysis.iterations, " passes",
                                  report.analysis.converged ? "" : ": did not come to rest", "\n");
  if (!report.left_out.empty()) {
    const std::vector<std::string> shown(
        report.left_out.begin(), report.left_out.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                               report.left_out.size(), kNamed)));
    absl::StrAppend(&text, "left out, as not every set has them: ", absl::StrJoin(shown, ", "),
                    report.left_out.size() > kNamed
                        ? absl::StrCat(" and ", report.left_out.size() - kNamed, " more")
                        : "",
                    "\n");
  }
  absl::StrAppend(&text, "results are in ", folder,
                  "\n  look first at heatmap.png, sets.csv, matrix.csv\n");
  return text;
}

absl::Status CheckOut(const GpaFlags& flags) {
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  for (const std::string& path : flags.paths) {
    std::error_code unknown;  // Then they differ.
    if (std::filesystem::equivalent(path, flags.out, unknown)) {
      return absl::InvalidArgumentError("--out " + flags.out +
                                        " is a folder of landmarks: the results would be taken for "
                                        "landmarks next time");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<int> Gpa(const GpaFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const ProcrustesOptions options, ToOptions(flags));
  COHORT_ASSIGN_OR_RETURN(std::vector<ReadLandmarkSet> sets, ReadLandmarkFiles(flags.paths));
  COHORT_RETURN_IF_ERROR(SortByName(sets));
  COHORT_ASSIGN_OR_RETURN(const std::vector<GpaInput> inputs, HashInputs(flags.paths));
  COHORT_ASSIGN_OR_RETURN(const GpaReport report, Analyze(sets, options));
  COHORT_RETURN_IF_ERROR(CheckOut(flags));
  FolderWriter out(flags.out);
  COHORT_RETURN_IF_ERROR(WriteFiles(report, inputs, out));
  if (!flags.json) {
    std::cout << Text(report, flags.out);
    return kExitOk;
  }
  nlohmann::json json = {{"folder", flags.out},
                         {"sets", report.sets.size()},
                         {"landmarks", report.analysis.names},
                         {"landmarks_left_out", report.left_out},
                         {"iterations", report.analysis.iterations},
                         {"converged", report.analysis.converged}};
  for (const ResultFile& file : out.Files()) {
    json["files"].push_back(file.name);
  }
  std::cout << json.dump(2) << "\n";
  return kExitOk;
}

}  // namespace

void AddGpaCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "gpa", "generalised Procrustes analysis of landmarks; needs no meshes and no server");
  const auto flags = std::make_shared<GpaFlags>();
  command
      ->add_option("files", flags->paths,
                   "landmark files (csv tables of many meshes, .pp, .fcsv, .mrk.json) or folders "
                   "of them")
      ->required();
  command->add_option("--out", flags->out, "folder for the results; made if new")->required();
  command
      ->add_option("--size", flags->size,
                   "normalized (shape: every set gets centroid size 1) or kept (form: sizes count, "
                   "in mm)")
      ->capture_default_str();
  command
      ->add_option("--variant", flags->variant,
                   "exact, or fidentis (the numbers of FIDENTIS Analyst, defects included)")
      ->capture_default_str();
  command->add_flag("--json", flags->json, "print JSON for scripts");
  command->footer(
      "Compares the landmarks that all sets have. Exit codes: 0 done, 1 failed, 2 wrong usage or "
      "landmarks, 7 no such file.\n"
      "Examples:\n"
      "  cohort gpa landmarks.csv --out gpa\n"
      "  cohort gpa slicer_markups/ --out gpa --size kept");
  command->callback([flags, &action] { action = [flags] { return Gpa(*flags); }; });
}

}  // namespace cohort
