// `cohort run`: everything on this machine, with one command.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <thread>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/job_flags.h"
#include "client/labels_csv.h"
#include "client/landmark_files.h"
#include "client/local_cluster.h"
#include "client/output/exit_codes.h"
#include "client/output/job_text.h"
#include "client/preview.h"
#include "client/results_folder.h"
#include "client/upload.h"
#include "common/base/process.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr double kStartSeconds = 30;
constexpr size_t kHashInName = 10;

struct RunFlags {
  std::string folder;
  std::string out;
  std::string labels;
  std::string data;
  int workers = 1;
  int threads = 0;
  bool keep_data = false;
  bool no_report = false;
  bool json = false;
  JobFlags spec;
};

/// What a run is about, read and checked.
struct RunInput {
  JobSpec spec;
  std::vector<MeshFile> files;
  std::string landmarks;  ///< Landmark blob; empty: none.
};

/// What would give the same results: parameters, files and labels.
Digest RequestDigest(const JobSpec& spec, const std::vector<MeshFile>& files) {
  Sha256 hash;
  hash.Update(ToJson(spec).dump());
  for (const MeshFile& file : files) {
    hash.Update(nlohmann::json({file.mesh.name, file.mesh.raw.Hex(), file.mesh.labels}).dump());
  }
  return hash.Finish();
}

/// Ctrl-C and SIGTERM: stops the children, keeps their data, ends the program.
void EndOnSignal(LocalCluster& cluster, const std::atomic<bool>& done) {
  const int signal = WaitForStopSignal(&done, 0);
  if (signal == 0) {
    return;
  }
  std::cerr << "\ncohort: interrupted; run the same command again to go on from here\n";
  cluster.Stop();
  std::_Exit(kExitInterrupted);
}

absl::StatusOr<ResultsDigest> Compute(const RunFlags& flags,
                                      const RunInput& input,
                                      const LocalCluster& cluster) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(cluster.Address()));
  COHORT_RETURN_IF_ERROR(session->WaitUntilReady(kStartSeconds));
  const std::string request = RequestDigest(input.spec, input.files).Hex();
  const std::string folder_name =
      std::filesystem::weakly_canonical(flags.folder).filename().string();
  const std::string set = folder_name.substr(0, 100) + "-" + request.substr(0, kHashInName);
  COHORT_RETURN_IF_ERROR(Upload(*session, set, input.files).status());
  if (!input.landmarks.empty()) {
    COHORT_RETURN_IF_ERROR(session->SendBlob(input.landmarks));
  }
  COHORT_ASSIGN_OR_RETURN(Job job, session->CreateJob(set, input.spec, request));
  bool wrote_preview = false;
  const auto write_preview = [&](const Job& now) -> std::string {
    if (wrote_preview || !HasFreshPreview(now)) {
      return "";
    }
    wrote_preview = true;
    const absl::Status written = WritePreview(*session, now, flags.out).status();
    return written.ok() ? "preview (corresponded RMS, not the exact matrix): " +
                              (std::filesystem::path(flags.out) / "preview_matrix.csv").string()
                        : "no preview: " + std::string(written.message());
  };
  COHORT_ASSIGN_OR_RETURN(job, FollowJob(*session, job.id, write_preview));
  if (job.state != JobState::kSucceeded) {
    ResultsDigest ended;
    ended.job = job;
    return ended;
  }
  return WriteResults(*session, job.id,
                      {.report = flags.no_report ? ResultsOptions::Report::kLeaveOut
                                                 : ResultsOptions::Report::kWrite},
                      flags.out);
}

absl::StatusOr<int> RunOnCluster(const RunFlags& flags,
                                 const RunInput& input,
                                 const std::filesystem::path& data) {
  BlockStopSignals();
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<LocalCluster> cluster,
                          LocalCluster::Start({.data_dir = data,
                                               .workers = flags.workers,
                                               .threads = flags.threads,
                                               .on_failure = EndProgramOnFailure(data)}));
  std::atomic<bool> done = false;
  std::thread signals([&] { EndOnSignal(*cluster, done); });
  const absl::StatusOr<ResultsDigest> results = Compute(flags, input, *cluster);
  done = true;
  signals.join();
  const absl::Status health = cluster->Health();
  cluster->Stop();
  if (!results.ok()) {
    std::cerr << "cohort: logs are in " << data.string() << "\n";
    return health.ok() ? results.status() : health;
  }
  if (results->job.state == JobState::kSucceeded) {
    std::cout << (flags.json ? ResultsToJson(*results, flags.out).dump(2) + "\n"
                             : ResultsToText(*results, flags.out));
  } else if (flags.json) {
    std::cout << JobToJson(results->job).dump(2) << "\n";
  }
  return ExitCodeOfJob(results->job);
}

absl::StatusOr<RunInput> ReadInput(const RunFlags& flags) {
  RunInput input;
  COHORT_ASSIGN_OR_RETURN(input.spec, flags.spec.ToSpec());
  COHORT_ASSIGN_OR_RETURN(const auto paths, ListMeshFiles(flags.folder));
  if (paths.size() < 2) {
    return absl::FailedPreconditionError("folder " + flags.folder +
                                         " has one mesh; at least two are needed to compare");
  }
  if (flags.spec.UsesLandmarks()) {
    std::vector<std::string> names;
    names.reserve(paths.size());
    for (const std::filesystem::path& path : paths) {
      names.push_back(path.filename().string());
    }
    COHORT_ASSIGN_OR_RETURN(input.landmarks,
                            MakeLandmarkBlob(flags.spec.landmarks, names, input.spec));
  }
  Labels labels;
  if (!flags.labels.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(flags.labels));
    COHORT_ASSIGN_OR_RETURN(labels, ParseLabels(text, flags.labels));
  }
  // Before hours are spent: can the results be written at all?
  COHORT_RETURN_IF_ERROR(PrepareFolder(flags.out));
  std::error_code unknown;  // Then they differ.
  if (std::filesystem::equivalent(flags.folder, flags.out, unknown)) {
    return absl::InvalidArgumentError("--out " + flags.out +
                                      " is the folder of the scans: the results would be taken for "
                                      "scans next time");
  }
  COHORT_ASSIGN_OR_RETURN(input.files, DescribeFiles(paths, labels));
  return input;
}

absl::StatusOr<int> Run(const RunFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const RunInput input, ReadInput(flags));
  const std::filesystem::path data = flags.data.empty()
                                         ? std::filesystem::path(flags.out) / ".cohort-data"
                                         : std::filesystem::path(flags.data);
  COHORT_RETURN_IF_ERROR(PrepareFolder(data));
  COHORT_ASSIGN_OR_RETURN(const int exit_code, RunOnCluster(flags, input, data));
  if (flags.data.empty() && !flags.keep_data &&
      (exit_code == kExitOk || exit_code == kExitRejected)) {
    std::error_code ignored;  // Left behind, it only takes space.
    std::filesystem::remove_all(data, ignored);
  }
  return exit_code;
}

}  // namespace

void AddRunCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "run", "compare all meshes of a folder on this machine and write the results");
  const auto flags = std::make_shared<RunFlags>();
  command->add_option("folder", flags->folder, "folder with .obj, .ply or .stl files")->required();
  command->add_option("--out", flags->out, "folder for the results; made if new")->required();
  command->add_option("--labels", flags->labels,
                      "CSV with columns file, person and any others, kept with the meshes");
  command->add_option("--workers", flags->workers, "worker processes")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command
      ->add_option("--threads", flags->threads,
                   "tasks at once in each worker; 0: processors / workers")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option(
      "--data", flags->data,
      "folder for catalog and blobs, kept for later runs [OUT/.cohort-data, removed "
      "when the job has succeeded]");
  command->add_flag("--keep-data", flags->keep_data, "keep OUT/.cohort-data");
  command->add_flag("--no-report", flags->no_report, "leave out report.html");
  command->add_flag("--json", flags->json, "print JSON for scripts");
  flags->spec.AddTo(*command);
  command->footer(
      "An interrupted run goes on where it was when the same command is given again.\n"
      "Examples:\n"
      "  cohort run scans/ --out results/ --labels people.csv --method average\n"
      "  cohort run scans/ --out results/ --landmarks landmarks.csv");
  command->callback([flags, &action] { action = [flags] { return Run(*flags); }; });
}

}  // namespace cohort
