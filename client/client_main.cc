#include "client/client_main.h"

#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "client/commands/command.h"
#include "client/output/exit_codes.h"
#include "common/base/version.h"

namespace cohort {
namespace {

constexpr char kFooter[] =
    "Examples:\n"
    "  cohort demo --out demo                           make a synthetic cohort\n"
    "  cohort run demo --out results --labels demo/labels.csv\n"
    "  cohort analyze results --by sex --out statistics clusters, groups, identification\n"
    "  cohort gpa landmarks.csv --out gpa               compare landmarks alone\n"
    "  cohort serve --data /var/lib/cohort --listen 0.0.0.0:7450\n"
    "  cohort work --server coordinator:7450\n"
    "  cohort add scans/*.ply --set brno-2016 --server coordinator:7450\n"
    "  cohort estimate --set brno-2016 --server coordinator:7450\n"
    "  cohort submit --set brno-2016 --wait --server coordinator:7450\n"
    "  cohort results j-000001 --out results --server coordinator:7450\n"
    "  cohort remeasure j-000001 --metric p95 --out p95 --server coordinator:7450\n"
    "  cohort identify j-000001 unknown.ply --server coordinator:7450\n"
    "  cohort compare before.ply after.ply --out change\n"
    "  cohort evaluate faces/ --labels people.csv --out evaluation\n"
    "\n"
    "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 done but meshes were rejected,\n"
    "  4 the job failed, 5 the job was cancelled, 6 server unreachable,\n"
    "  7 no such job, set or file, 130 interrupted.";

int Dispatch(int argc, char** argv) {
  CLI::App app("cohort: compares every 3D face scan of a collection with every other.");
  app.set_version_flag("--version", "cohort " + std::string(BuildVersion()));
  app.require_subcommand(1);
  app.footer(kFooter);
  Action action;
  AddRunCommand(app, action);
  AddDemoCommand(app, action);
  AddGpaCommand(app, action);
  AddServeCommand(app, action);
  AddWorkCommand(app, action);
  AddAddCommand(app, action);
  AddEstimateCommand(app, action);
  AddSubmitCommand(app, action);
  AddStatusCommand(app, action);
  AddWatchCommand(app, action);
  AddJobsCommand(app, action);
  AddResultsCommand(app, action);
  AddRemeasureCommand(app, action);
  AddPairCommand(app, action);
  AddCompareCommand(app, action);
  AddIdentifyCommand(app, action);
  AddShapeCommand(app, action);
  AddEvaluateCommand(app, action);
  AddAnalyzeCommand(app, action);
  AddMantelCommand(app, action);
  AddManageCommands(app, action);
  AddWorkersCommand(app, action);
  AddTopCommand(app, action);
  AddGcCommand(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  const absl::StatusOr<int> exit_code = action();
  if (!exit_code.ok()) {
    std::cerr << "cohort: " << exit_code.status().message() << "\n";
    return ExitCodeOf(exit_code.status());
  }
  return *exit_code;
}

}  // namespace

int ClientMain(int argc, char** argv) {
  try {
    return Dispatch(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "cohort: " << error.what() << "\n";
    return kExitFailed;
  }
}

}  // namespace cohort
