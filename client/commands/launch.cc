// `cohort serve` and `cohort work`: thin launchers of cohort-server and cohort-worker.
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "client/child_process.h"
#include "client/commands/command.h"

namespace cohort {
namespace {

/// Becomes the program; only returns if that fails.
absl::StatusOr<int> Become(const std::string& name, const std::vector<std::string>& arguments) {
  std::string program = SiblingProgram(name).string();
  std::vector<std::string> copies = arguments;
  std::vector<char*> argv = {program.data()};
  for (std::string& argument : copies) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  execvp(program.c_str(), argv.data());
  return absl::NotFoundError("cannot start " + program + ": " +
                             std::generic_category().message(errno));
}

void AddLauncher(CLI::App& app,
                 Action& action,
                 const std::string& command_name,
                 const std::string& program,
                 const std::string& description) {
  CLI::App* command = app.add_subcommand(command_name, description);
  command->prefix_command();  // Everything after the name belongs to the program.
  command->set_help_flag();
  command->callback([command, program, &action] {
    action = [arguments = command->remaining(), program] { return Become(program, arguments); };
  });
}

}  // namespace

void AddServeCommand(CLI::App& app, Action& action) {
  AddLauncher(app, action, "serve", "cohort-server",
              "start a server (cohort-server; options: cohort serve --help)");
}

void AddWorkCommand(CLI::App& app, Action& action) {
  AddLauncher(app, action, "work", "cohort-worker",
              "start a worker (cohort-worker; options: cohort work --help)");
}

}  // namespace cohort
