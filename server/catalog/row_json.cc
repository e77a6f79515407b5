#include "server/catalog/row_json.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/jobs/json_fields.h"

namespace cohort {
namespace {

using nlohmann::json;

absl::StatusOr<json> Parse(const char* what, const std::string& text) {
  json parsed = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (parsed.is_discarded()) {
    return absl::DataLossError(std::string(what) + ": not JSON: '" + text.substr(0, 80) + "'");
  }
  return parsed;
}

/// Values that were renamed since a build wrote them.
void UseTodaysNames(json& spec) {
  const json::json_pointer scale("/icp/scale");
  if (spec.contains(scale) && spec[scale] == "free") {
    spec[scale] = "least-squares";
  }
}

}  // namespace

std::string LabelsToText(const std::map<std::string, std::string>& labels) {
  return json(labels).dump();
}

absl::StatusOr<std::map<std::string, std::string>> LabelsFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(const json parsed, Parse("labels", text));
  std::map<std::string, std::string> labels;
  for (const auto& [name, value] : parsed.items()) {
    if (!parsed.is_object() || !value.is_string()) {
      return absl::DataLossError("labels: expected an object of texts: '" + text.substr(0, 80) +
                                 "'");
    }
    labels[name] = value.get<std::string>();
  }
  return labels;
}

std::string SpecToText(const JobSpec& spec) {
  return ToJson(spec).dump();
}

absl::StatusOr<JobSpec> SpecFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(json parsed, Parse("job spec", text));
  UseTodaysNames(parsed);
  absl::StatusOr<JobSpec> spec = JobSpecFromJson(parsed);
  if (!spec.ok()) {
    return absl::DataLossError(std::string(spec.status().message()));
  }
  return spec;
}

std::string ProgressToText(const Progress& progress) {
  json stages = json::array();
  for (const StageTime& stage : progress.stages) {
    stages.push_back({{"name", stage.name},
                      {"started_unix_ms", stage.started_unix_ms},
                      {"finished_unix_ms", stage.finished_unix_ms}});
  }
  return json{{"stages", std::move(stages)},           {"stage", progress.stage},
              {"tasks_done", progress.tasks_done},     {"tasks_total", progress.tasks_total},
              {"cost_done", progress.cost_done},       {"cost_total", progress.cost_total},
              {"tasks_reused", progress.tasks_reused}, {"tasks_given_up", progress.tasks_given_up}}
      .dump();
}

absl::StatusOr<Progress> ProgressFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(const json parsed, Parse("progress", text));
  Progress progress;
  JsonFields fields(parsed, "progress", absl::StatusCode::kDataLoss, Presence::kOptional);
  fields.Read("stage", progress.stage);
  fields.Read("tasks_done", progress.tasks_done);
  fields.Read("tasks_total", progress.tasks_total);
  fields.Read("cost_done", progress.cost_done);
  fields.Read("cost_total", progress.cost_total);
  fields.Read("tasks_reused", progress.tasks_reused);
  fields.Read("tasks_given_up", progress.tasks_given_up);
  fields.ReadObjects("stages", [&progress](JsonFields& item) {
    StageTime& stage = progress.stages.emplace_back();
    item.Read("name", stage.name);
    item.Read("started_unix_ms", stage.started_unix_ms);
    item.Read("finished_unix_ms", stage.finished_unix_ms);
  });
  COHORT_RETURN_IF_ERROR(fields.Finish());
  return progress;
}

// Counters and ingested meshes travel as task results, which common/jobs reads and writes.
std::string CountersToText(const Counters& counters) {
  TaskResult carrier;
  carrier.counters = counters;
  return ResultToText(carrier);
}

absl::StatusOr<Counters> CountersFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(const TaskResult carrier, ResultFromText(text));
  return carrier.counters;
}

std::string IngestedToText(const IngestedMesh& mesh) {
  TaskResult carrier;
  carrier.ingested = {mesh};
  carrier.ingested[0].index = 0;
  return ResultToText(carrier);
}

absl::StatusOr<IngestedMesh> IngestedFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(TaskResult carrier, ResultFromText(text));
  if (carrier.ingested.size() != 1) {
    return absl::DataLossError("ingested mesh: " + std::to_string(carrier.ingested.size()) +
                               " meshes instead of one");
  }
  return std::move(carrier.ingested[0]);
}

std::string OutcomeToText(const JobMesh& mesh) {
  if (!mesh.ingested) {
    return "";
  }
  TaskResult carrier;
  carrier.ingested = {*mesh.ingested};
  carrier.ingested[0].index = 0;
  if (mesh.copy) {
    carrier.copies = {*mesh.copy};
    carrier.copies[0].index = 0;
  }
  return ResultToText(carrier);
}

absl::Status OutcomeFromText(const std::string& text, int32_t index, JobMesh& mesh) {
  mesh.ingested.reset();
  mesh.copy.reset();
  if (text.empty()) {
    return absl::OkStatus();
  }
  COHORT_ASSIGN_OR_RETURN(TaskResult carrier, ResultFromText(text));
  if (carrier.ingested.size() != 1 || carrier.copies.size() > 1) {
    return absl::DataLossError("mesh of a job: " + std::to_string(carrier.ingested.size()) +
                               " meshes and " + std::to_string(carrier.copies.size()) +
                               " copies instead of one");
  }
  mesh.ingested = std::move(carrier.ingested[0]);
  mesh.ingested->index = index;
  if (!carrier.copies.empty()) {
    mesh.copy = std::move(carrier.copies[0]);
    mesh.copy->index = index;
  }
  return absl::OkStatus();
}

std::string OutputsToText(const JobOutputs& outputs) {
  return ToJson(outputs).dump();
}

absl::StatusOr<JobOutputs> OutputsFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(const json parsed, Parse("job outputs", text));
  return JobOutputsFromJson(parsed);
}

std::string ResultToText(const TaskResult& result) {
  return ToJson(result).dump();
}

absl::StatusOr<TaskResult> ResultFromText(const std::string& text) {
  COHORT_ASSIGN_OR_RETURN(const json parsed, Parse("task result", text));
  return TaskResultFromJson(parsed);
}

absl::StatusOr<Digest> DigestFromText(const std::string& text) {
  if (text.empty()) {
    return Digest();
  }
  absl::StatusOr<Digest> digest = Digest::FromHex(text);
  if (!digest.ok()) {
    return absl::DataLossError(std::string(digest.status().message()));
  }
  return digest;
}

}  // namespace cohort
