// `cohort estimate`: what a job would take.
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "client/commands/command.h"
#include "client/job_flags.h"
#include "client/landmark_files.h"
#include "client/output/estimate_text.h"
#include "client/output/exit_codes.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

struct EstimateFlags {
  ServerFlags server;
  std::string set;
  JobFlags spec;
};

absl::StatusOr<int> ShowEstimate(const EstimateFlags& flags) {
  COHORT_ASSIGN_OR_RETURN(JobSpec spec, flags.spec.ToSpec());
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, flags.server.Connect());
  if (flags.spec.UsesLandmarks()) {
    COHORT_ASSIGN_OR_RETURN(const std::vector<SetMesh> meshes, session->ListMeshes(flags.set));
    std::vector<std::string> names;
    names.reserve(meshes.size());
    for (const SetMesh& mesh : meshes) {
      names.push_back(mesh.name);
    }
    // Checked as for the job; nothing is sent.
    COHORT_RETURN_IF_ERROR(MakeLandmarkBlob(flags.spec.landmarks, names, spec).status());
  }
  COHORT_ASSIGN_OR_RETURN(const Estimate estimate, session->EstimateJob(flags.set, spec));
  std::cout << (flags.server.json ? EstimateToJson(estimate).dump(2) + "\n"
                                  : EstimateToText(estimate));
  return kExitOk;
}

}  // namespace

void AddEstimateCommand(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "estimate", "tell what a job over a set would take: pairs, time, bytes; starts nothing");
  const auto flags = std::make_shared<EstimateFlags>();
  flags->server.AddTo(*command);
  command->add_option("--set", flags->set, "name of the set, already added")->required();
  flags->spec.AddTo(*command);
  command->footer(
      "Takes the options of submit. Times go by what such tasks have taken on this server since "
      "it\n"
      "started, where there were any, else by assumed rates; the answer says which. A set that no\n"
      "job has read yet is judged by the sizes of its files. Needs a server: a folder is "
      "estimated\n"
      "by adding it to a set first.\n"
      "Example: cohort estimate --set brno-2016 --method each --retention vectors");
  command->callback([flags, &action] { action = [flags] { return ShowEstimate(*flags); }; });
}

}  // namespace cohort
