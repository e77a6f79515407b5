// Commands about what a server and its workers do now: workers, top.
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/output/exit_codes.h"
#include "client/output/worker_text.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr int kListedJobs = 100;
constexpr size_t kListedTasks = 20;

struct WorkersFlags {
  ServerFlags server;
  double interval_seconds = 2;
  bool once = false;
};

absl::StatusOr<int> ShowWorkers(const WorkersFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const std::vector<WorkerStatus> workers, session->ListWorkers());
  if (flags.server.json) {
    std::cout << WorkersToJson(workers).dump(2) << "\n";
  } else if (workers.empty()) {
    std::cout << "no workers; start one with: cohort work --server " << session->Address() << "\n";
  } else {
    std::cout << WorkersToTable(workers);
  }
  return kExitOk;
}

absl::StatusOr<int> ShowTop(const WorkersFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  const bool is_terminal = isatty(STDOUT_FILENO) == 1;
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const std::vector<WorkerStatus> workers, session->ListWorkers());
    COHORT_ASSIGN_OR_RETURN(const std::vector<Job> jobs, session->ListJobs(kListedJobs));
    std::cout << (is_terminal && !flags.once ? "\x1b[H\x1b[2J" : "")
              << Overview(jobs, workers, kListedTasks) << std::flush;
    if (flags.once) {
      return kExitOk;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(flags.interval_seconds));
  }
}

}  // namespace

void AddWorkersCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("workers", "list the workers of a server");
  const auto flags = std::make_shared<WorkersFlags>();
  flags->server.AddTo(*command);
  command->footer("Example: cohort workers --server coordinator:7450");
  command->callback([flags, &action] { action = [flags] { return ShowWorkers(*flags); }; });
}

void AddTopCommand(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("top", "show what a server and its workers do, again and again");
  const auto flags = std::make_shared<WorkersFlags>();
  flags->server.AddTo(*command);
  command->add_option("--interval", flags->interval_seconds, "seconds between two looks")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->add_flag("--once", flags->once, "look once");
  command->footer("Ctrl-C ends it.\nExample: cohort top --server coordinator:7450");
  command->callback([flags, &action] { action = [flags] { return ShowTop(*flags); }; });
}

}  // namespace cohort
