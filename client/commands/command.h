#pragma once

#include <functional>
#include <memory>
#include <string>

#include <absl/status/statusor.h>
#include <CLI/CLI.hpp>

#include "client/session.h"

namespace cohort {

/// What the chosen subcommand will do: returns the exit code, or the error that becomes one.
using Action = std::function<absl::StatusOr<int>()>;

/// Options shared by the commands that talk to a server.
struct ServerFlags {
  std::string server = "127.0.0.1:7450";
  bool json = false;

  /// Adds --server (or COHORT_SERVER in the environment) and --json.
  void AddTo(CLI::App& command);
  [[nodiscard]] absl::StatusOr<std::unique_ptr<Session>> Connect() const;
};

// One function per subcommand: declares its options and sets `action` when it is chosen.
void AddRunCommand(CLI::App& app, Action& action);
void AddServeCommand(CLI::App& app, Action& action);
void AddWorkCommand(CLI::App& app, Action& action);
void AddAddCommand(CLI::App& app, Action& action);
void AddEstimateCommand(CLI::App& app, Action& action);
void AddSubmitCommand(CLI::App& app, Action& action);
void AddStatusCommand(CLI::App& app, Action& action);
void AddWatchCommand(CLI::App& app, Action& action);
void AddJobsCommand(CLI::App& app, Action& action);
/// cancel, pause, resume, retry, delete, remove.
void AddManageCommands(CLI::App& app, Action& action);
void AddWorkersCommand(CLI::App& app, Action& action);
void AddGcCommand(CLI::App& app, Action& action);
void AddTopCommand(CLI::App& app, Action& action);
void AddResultsCommand(CLI::App& app, Action& action);
void AddRemeasureCommand(CLI::App& app, Action& action);
void AddPairCommand(CLI::App& app, Action& action);
void AddCompareCommand(CLI::App& app, Action& action);
void AddIdentifyCommand(CLI::App& app, Action& action);
void AddEvaluateCommand(CLI::App& app, Action& action);
void AddShapeCommand(CLI::App& app, Action& action);
void AddGpaCommand(CLI::App& app, Action& action);
void AddDemoCommand(CLI::App& app, Action& action);
void AddAnalyzeCommand(CLI::App& app, Action& action);
void AddMantelCommand(CLI::App& app, Action& action);

/// Follows a job until it has ended, showing its progress on stderr.
/// @param remark  asked at every change for a line to be shown besides; empty: none.
/// @return the job; as Session::WatchJob.
[[nodiscard]] absl::StatusOr<Job> FollowJob(
    Session& session, const JobId& id, const std::function<std::string(const Job&)>& remark = {});

/// The exit code for a job that has ended (kExitOk, kExitRejected, kExitJobFailed, kExitCancelled).
/// Prints the job's error to stderr.
[[nodiscard]] int ExitCodeOfJob(const Job& job);

}  // namespace cohort
