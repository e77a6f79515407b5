#include "common/jobs/job_state.h"

#include <array>

#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/jobs/json_fields.h"

namespace cohort {
namespace {

constexpr std::array<JobState, 6> kAllStates = {JobState::kQueued,    JobState::kRunning,
                                                JobState::kSucceeded, JobState::kFailed,
                                                JobState::kCancelled, JobState::kPaused};

nlohmann::json ToJson(const std::vector<Digest>& digests) {
  nlohmann::json names = nlohmann::json::array();
  for (const Digest& digest : digests) {
    names.push_back(digest.Hex());
  }
  return names;
}

}  // namespace

std::string_view JobStateName(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kSucceeded:
      return "succeeded";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
    case JobState::kPaused:
      return "paused";
  }
  return "unknown";
}

std::optional<JobState> JobStateFromName(std::string_view name) {
  for (const JobState state : kAllStates) {
    if (JobStateName(state) == name) {
      return state;
    }
  }
  return std::nullopt;
}

nlohmann::json ToJson(const JobOutputs& outputs) {
  nlohmann::json imported = nlohmann::json::array();
  for (const ImportedPairs& pairs : outputs.imported) {
    imported.push_back({{"tiles", ToJson(pairs.tiles)},
                        {"fields", ToJson(pairs.fields)},
                        {"mesh_of", pairs.mesh_of}});
  }
  return {
      {"tiles", ToJson(outputs.tiles)},
      {"alignments", ToJson(outputs.alignments)},
      {"mean_shape", outputs.mean_shape.Hex()},
      {"summary", outputs.summary.Hex()},
      {"fields", ToJson(outputs.fields)},
      {"base_choice", outputs.base_choice.Hex()},
      {"preview", ToJson(outputs.preview)},
      {"variation_shape", outputs.variation_shape.Hex()},
      {"poses", ToJson(outputs.poses)},
      {"signatures", ToJson(outputs.signatures)},
      {"frame", {{"reference", outputs.frame.reference.Hex()}, {"center", outputs.frame.center}}},
      {"imported", std::move(imported)},
  };
}

absl::StatusOr<JobOutputs> JobOutputsFromJson(const nlohmann::json& json) {
  JobOutputs outputs;
  JsonFields fields(json, "job outputs", absl::StatusCode::kDataLoss, Presence::kOptional);
  fields.Read("tiles", outputs.tiles);
  fields.Read("alignments", outputs.alignments);
  fields.Read("mean_shape", outputs.mean_shape);
  fields.Read("summary", outputs.summary);
  fields.Read("fields", outputs.fields);
  fields.Read("base_choice", outputs.base_choice);
  fields.Read("preview", outputs.preview);
  fields.Read("variation_shape", outputs.variation_shape);
  fields.Read("poses", outputs.poses);
  fields.Read("signatures", outputs.signatures);
  fields.ReadObject("frame", [&outputs](JsonFields& frame) {
    frame.Read("reference", outputs.frame.reference);
    frame.Read("center", outputs.frame.center);
  });
  fields.ReadObjects("imported", [&outputs](JsonFields& item) {
    ImportedPairs& pairs = outputs.imported.emplace_back();
    item.Read("tiles", pairs.tiles);
    item.Read("fields", pairs.fields);
    item.Read("mesh_of", pairs.mesh_of);
  });
  COHORT_RETURN_IF_ERROR(fields.Finish());
  return outputs;
}

}  // namespace cohort
