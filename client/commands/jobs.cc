// Commands about jobs on a server: submit, status, watch, jobs, results.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <random>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/job_flags.h"
#include "client/job_source.h"
#include "client/landmark_files.h"
#include "client/output/estimate_text.h"
#include "client/output/exit_codes.h"
#include "client/output/job_text.h"
#include "client/preview.h"
#include "client/proof.h"
#include "client/results_folder.h"
#include "common/base/status_macros.h"
#include "common/base/thread_pool.h"

namespace cohort {
namespace {

struct JobCommandFlags {
  ServerFlags server;
  std::string job;
  std::string set;
  std::string out;
  std::string metric;
  std::string meshes;
  std::string request_id;
  JobFlags spec;
  bool wait = false;
  bool preview = false;
  std::optional<int64_t> verify;
  uint64_t seed = 1;
  bool no_report = false;
  int limit = 20;
};

void Print(const ServerFlags& flags, const Job& job) {
  std::cout << (flags.json ? JobToJson(job).dump(2) + "\n" : JobToText(job));
}

std::string RandomId() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) {
    id += std::to_string(random());
  }
  return id;
}

absl::Status SendLandmarks(const JobCommandFlags& flags, Session& session, JobSpec& spec) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<SetMesh> meshes, session.ListMeshes(flags.set));
  std::vector<std::string> names;
  names.reserve(meshes.size());
  for (const SetMesh& mesh : meshes) {
    names.push_back(mesh.name);
  }
  COHORT_ASSIGN_OR_RETURN(const std::string blob,
                          MakeLandmarkBlob(flags.spec.landmarks, names, spec));
  return session.SendBlob(blob);
}

absl::StatusOr<int> Submit(const JobCommandFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(JobSpec spec, flags.spec.ToSpec());
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  if (flags.spec.UsesLandmarks()) {
    COHORT_RETURN_IF_ERROR(SendLandmarks(flags, *session, spec));
  }
  if (spec.method == Method::kEach) {
    // No more than a word of warning: a job that cannot be planned is refused below.
    const absl::StatusOr<Estimate> estimate = session->EstimateJob(flags.set, spec);
    std::cerr << (estimate.ok() ? EstimateWarnings(*estimate) : "");
  }
  // With an id of its own, a request that has to be repeated cannot start a second job.
  const std::string request_id = flags.request_id.empty() ? RandomId() : flags.request_id;
  COHORT_ASSIGN_OR_RETURN(Job job, session->CreateJob(flags.set, spec, request_id));
  if (!flags.wait) {
    if (flags.server.json) {
      Print(flags.server, job);
    } else {
      std::cout << job.id.value << "\n";
    }
    return kExitOk;
  }
  COHORT_ASSIGN_OR_RETURN(job, FollowJob(*session, job.id));
  Print(flags.server, job);
  return ExitCodeOfJob(job);
}

absl::StatusOr<int> ShowStatus(const JobCommandFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const Job job, session->GetJob(JobId{flags.job}));
  Print(flags.server, job);
  return kExitOk;
}

absl::StatusOr<int> Watch(const JobCommandFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const Job job, FollowJob(*session, JobId{flags.job}));
  Print(flags.server, job);
  return ExitCodeOfJob(job);
}

absl::StatusOr<int> List(const JobCommandFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const std::vector<Job> jobs, session->ListJobs(flags.limit));
  if (!flags.server.json) {
    std::cout << (jobs.empty() ? "no jobs yet\n" : JobsToTable(jobs));
    return kExitOk;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const Job& job : jobs) {
    list.push_back(JobToJson(job));
  }
  std::cout << list.dump(2) << "\n";
  return kExitOk;
}

absl::StatusOr<int> Preview(const JobCommandFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const Job job, session->GetJob(JobId{flags.job}));
  COHORT_ASSIGN_OR_RETURN(const int64_t meshes, WritePreview(*session, job, flags.out));
  if (flags.server.json) {
    std::cout << nlohmann::json({{"job", job.id.value}, {"meshes", meshes}, {"folder", flags.out}})
                     .dump(2)
              << "\n";
  } else {
    std::cout << "preview of " << meshes << " meshes (corresponded RMS, not the exact matrix): "
              << (std::filesystem::path(flags.out) / "preview_matrix.csv").string() << "\n";
  }
  return kExitOk;
}

/// Measures some pairs once more; an error if a bit differs.
absl::StatusOr<int> Verify(const JobCommandFlags& flags) {
  const JobSource source{.server = flags.server, .job = flags.job};
  COHORT_ASSIGN_OR_RETURN(const OpenedJob opened, source.Open());
  COHORT_ASSIGN_OR_RETURN(const auto frame,
                          JobFrame::Open(*opened.session, opened.Blobs(), opened.id));
  ThreadPool threads(LocalThreads());
  COHORT_ASSIGN_OR_RETURN(const PairProof result,
                          ProvePairs(*opened.session, *frame, *flags.verify, flags.seed, threads));
  if (flags.server.json) {
    std::cout << nlohmann::json({{"job", opened.id.value},
                                 {"pairs", result.pairs},
                                 {"of", result.of},
                                 {"numbers", result.numbers},
                                 {"differences", result.differences}})
                     .dump(2)
              << "\n";
  } else {
    std::cout << "job " << opened.id.value << ": " << result.pairs << " of " << result.of
              << " directed pairs measured once more, "
              << (result.differences.empty()
                      ? "all " + std::to_string(result.numbers) + " numbers the same, bit by bit"
                      : std::to_string(result.differences.size()) + " of " +
                            std::to_string(result.numbers) + " numbers DIFFER")
              << "\n";
    for (const std::string& line : result.differences) {
      std::cout << "  " << line << "\n";
    }
  }
  return result.differences.empty() ? kExitOk : kExitFailed;
}

absl::StatusOr<ResultsOptions> ResultsOptionsOf(const JobCommandFlags& flags) {
  ResultsOptions options;
  if (flags.no_report) {
    options.report = ResultsOptions::Report::kLeaveOut;
  }
  if (!flags.metric.empty()) {
    options.metric = MetricFromName(flags.metric);
    if (!options.metric) {
      return absl::InvalidArgumentError("--metric " + flags.metric +
                                        ": expected rms, mean, geometric-mean, min, max, variance "
                                        "or p75");
    }
  }
  if (!flags.meshes.empty()) {
    options.aligned_meshes = MeshFormatFromName(flags.meshes);
    if (!options.aligned_meshes) {
      return absl::InvalidArgumentError("--meshes " + flags.meshes + ": expected ply, obj or stl");
    }
  }
  return options;
}

absl::StatusOr<int> Results(const JobCommandFlags& flags) {
  if (flags.verify) {
    return Verify(flags);
  }
  if (flags.out.empty()) {
    return absl::InvalidArgumentError("--out FOLDER is needed: where the results are written");
  }
  if (flags.preview) {
    return Preview(flags);
  }
  COHORT_ASSIGN_OR_RETURN(const ResultsOptions options, ResultsOptionsOf(flags));
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const ResultsDigest results,
                          WriteResults(*session, JobId{flags.job}, options, flags.out));
  std::cout << (flags.server.json ? ResultsToJson(results, flags.out).dump(2) + "\n"
                                  : ResultsToText(results, flags.out));
  return ExitCodeOfJob(results.job);
}

/// A subcommand with its flags; `run` is what it does.
std::pair<CLI::App*, std::shared_ptr<JobCommandFlags>> AddCommand(
    CLI::App& app,
    Action& action,
    const std::string& name,
    const std::string& description,
    absl::StatusOr<int> (*run)(const JobCommandFlags&)) {
  CLI::App* command = app.add_subcommand(name, description);
  const auto flags = std::make_shared<JobCommandFlags>();
  flags->server.AddTo(*command);
  command->callback([flags, run, &action] { action = [flags, run] { return run(*flags); }; });
  return {command, flags};
}

void AddJobArgument(CLI::App& command, JobCommandFlags& flags) {
  command.add_option("job", flags.job, "job id, e.g. j-000001")->required();
}

}  // namespace

void AddSubmitCommand(CLI::App& app, Action& action) {
  const auto [command, flags] =
      AddCommand(app, action, "submit", "start a job over a set; prints its id", Submit);
  command->add_option("--set", flags->set, "name of the set")->required();
  command->add_flag("--wait", flags->wait, "follow the job until it has ended");
  command->add_option("--request-id", flags->request_id,
                      "a second submission with the same id returns the first one's job");
  flags->spec.AddTo(*command);
  command->footer("Example: cohort submit --set brno-2016 --method average --wait");
}

void AddStatusCommand(CLI::App& app, Action& action) {
  const auto [command, flags] = AddCommand(app, action, "status", "show a job", ShowStatus);
  AddJobArgument(*command, *flags);
  command->footer("Example: cohort status j-000001 --json");
}

void AddWatchCommand(CLI::App& app, Action& action) {
  const auto [command, flags] =
      AddCommand(app, action, "watch", "follow a job until it has ended", Watch);
  AddJobArgument(*command, *flags);
  command->footer("Ctrl-C ends the watching, not the job.\nExample: cohort watch j-000001");
}

void AddJobsCommand(CLI::App& app, Action& action) {
  const auto [command, flags] = AddCommand(app, action, "jobs", "list jobs, newest first", List);
  command->add_option("--limit", flags->limit, "at most this many")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->footer("Example: cohort jobs --limit 5");
}

void AddResultsCommand(CLI::App& app, Action& action) {
  const auto [command, flags] =
      AddCommand(app, action, "results", "write the results of a job into a folder", Results);
  AddJobArgument(*command, *flags);
  command->add_option("--out", flags->out, "folder; made if new");
  command->add_option("--metric", flags->metric,
                      "another metric than the job's; nothing is computed anew");
  command->add_option("--meshes", flags->meshes,
                      "ply, obj or stl: also all meshes in the frame of the job, in OUT/aligned");
  command->add_flag("--no-report", flags->no_report, "leave out report.html");
  command->add_flag("--preview", flags->preview,
                    "only the preview of a job with --preview, which may still run");
  command
      ->add_option("--verify", flags->verify,
                   "write nothing; measure this many random pairs once more on this machine and "
                   "compare every bit")
      ->check(CLI::Range(int64_t{1}, int64_t{1'000'000'000}));
  command->add_option("--seed", flags->seed, "which pairs --verify draws")->capture_default_str();
  command->footer(
      "Examples:\n"
      "  cohort results j-000001 --out results --metric p75\n"
      "  cohort results j-000001 --out results --meshes ply\n"
      "  cohort results j-000001 --verify 100");
}

}  // namespace cohort
