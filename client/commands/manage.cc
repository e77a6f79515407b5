// Commands that change a job on its way, and what a set holds: pause, resume, retry, delete,
// remove.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/output/exit_codes.h"
#include "client/output/job_text.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

struct ManageFlags {
  ServerFlags server;
  std::string job;
  std::string set;
  std::vector<std::string> names;
  bool whole_set = false;
};

using JobCall = absl::StatusOr<Job> (Session::*)(const JobId&);

absl::StatusOr<int> ChangeJob(const ManageFlags& flags, JobCall call) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const Job job, ((*session).*call)(JobId{flags.job}));
  std::cout << (flags.server.json ? JobToJson(job).dump(2) + "\n" : JobToText(job));
  return kExitOk;
}

absl::StatusOr<int> Delete(const ManageFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_RETURN_IF_ERROR(session->DeleteJob(JobId{flags.job}));
  if (flags.server.json) {
    std::cout << nlohmann::json({{"deleted", flags.job}}).dump(2) << "\n";
  } else {
    std::cout << "deleted " << flags.job << "\n";
  }
  return kExitOk;
}

absl::StatusOr<int> Remove(const ManageFlags& flags) {
  if (flags.names.empty() != flags.whole_set) {
    return absl::InvalidArgumentError("name the meshes to be removed, or --all for the whole set");
  }
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  if (flags.whole_set) {
    COHORT_RETURN_IF_ERROR(session->DeleteSet(flags.set));
  }
  for (const std::string& name : flags.names) {
    COHORT_RETURN_IF_ERROR(session->RemoveMesh(flags.set, name));
  }
  if (flags.server.json) {
    std::cout << nlohmann::json({{"set", flags.set}, {"removed", flags.names}}).dump(2) << "\n";
  } else if (flags.whole_set) {
    std::cout << "removed the set " << flags.set << "\n";
  } else {
    std::cout << "removed " << flags.names.size() << " of " << flags.set << "\n";
  }
  return kExitOk;
}

std::pair<CLI::App*, std::shared_ptr<ManageFlags>> AddCommand(CLI::App& app,
                                                              const std::string& name,
                                                              const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description);
  const auto flags = std::make_shared<ManageFlags>();
  flags->server.AddTo(*command);
  command->footer("Example: cohort " + name + " j-000001");
  return {command, flags};
}

void AddJobCommand(CLI::App& app,
                   Action& action,
                   const std::string& name,
                   const std::string& description,
                   JobCall call) {
  const auto [command, flags] = AddCommand(app, name, description);
  command->add_option("job", flags->job, "job id, e.g. j-000001")->required();
  command->callback([flags = flags, call, &action] {
    action = [flags, call] { return ChangeJob(*flags, call); };
  });
}

}  // namespace

void AddManageCommands(CLI::App& app, Action& action) {
  AddJobCommand(app, action, "cancel", "stop a job", &Session::CancelJob);
  AddJobCommand(app, action, "pause", "hand out no new tasks of a job; those that run may end",
                &Session::PauseJob);
  AddJobCommand(app, action, "resume", "go on with a paused job", &Session::ResumeJob);
  AddJobCommand(app, action, "retry",
                "go on with a job that failed or was cancelled; what is done stays done",
                &Session::RetryJob);
  {
    const auto [command, flags] = AddCommand(app, "delete", "remove a job that has ended");
    command->add_option("job", flags->job, "job id, e.g. j-000001")->required();
    command->callback([flags = flags, &action] { action = [flags] { return Delete(*flags); }; });
  }
  const auto [command, flags] =
      AddCommand(app, "remove", "take meshes out of a set; jobs keep what they were created with");
  command->add_option("names", flags->names, "names of the meshes, as in the set");
  command->add_option("--set", flags->set, "name of the set")->required();
  command->add_flag("--all", flags->whole_set, "the whole set");
  command->footer("Example: cohort remove --set brno-2016 anna-2.ply bert-1.ply");
  command->callback([flags = flags, &action] { action = [flags] { return Remove(*flags); }; });
}

}  // namespace cohort
