// `cohort add`: uploads meshes into a named set.
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/files.h"
#include "client/labels_csv.h"
#include "client/output/exit_codes.h"
#include "client/upload.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

struct AddFlags {
  ServerFlags server;
  std::vector<std::string> paths;
  std::string set;
  std::string labels;
};

/// Folders stand for the mesh files in them.
absl::StatusOr<std::vector<std::filesystem::path>> ExpandPaths(
    const std::vector<std::string>& paths) {
  std::vector<std::filesystem::path> files;
  for (const std::string& path : paths) {
    if (!std::filesystem::is_directory(path)) {
      files.emplace_back(path);
      continue;
    }
    COHORT_ASSIGN_OR_RETURN(const auto inside, ListMeshFiles(path));
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

absl::StatusOr<int> Add(const AddFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(const auto paths, ExpandPaths(flags.paths));
  Labels labels;
  if (!flags.labels.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(flags.labels));
    COHORT_ASSIGN_OR_RETURN(labels, ParseLabels(text, flags.labels));
  }
  COHORT_ASSIGN_OR_RETURN(const std::vector<MeshFile> files, DescribeFiles(paths, labels));
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  COHORT_ASSIGN_OR_RETURN(const UploadCounts counts, Upload(*session, flags.set, files));
  if (flags.server.json) {
    const nlohmann::json json = {
        {"set", flags.set}, {"sent", counts.sent}, {"already_there", counts.known}};
    std::cout << json.dump(2) << "\n";
  } else {
    std::cout << "set " << flags.set << ": " << counts.sent << " files sent, " << counts.known
              << " were there already\n";
  }
  return kExitOk;
}

}  // namespace

void AddAddCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("add", "upload meshes into a named set");
  const auto flags = std::make_shared<AddFlags>();
  flags->server.AddTo(*command);
  command->add_option("files", flags->paths, "mesh files (.obj, .ply, .stl) or folders of them")
      ->required();
  command->add_option("--set", flags->set, "name of the set; made if new")->required();
  command->add_option("--labels", flags->labels,
                      "CSV with columns file, person and any others, kept with the meshes");
  command->footer("Example: cohort add scans/*.ply --set brno-2016 --labels people.csv");
  command->callback([flags, &action] { action = [flags] { return Add(*flags); }; });
}

}  // namespace cohort
