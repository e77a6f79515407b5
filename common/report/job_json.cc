#include "common/report/job_json.h"

#include <array>
#include <chrono>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "common/jobs/job_spec.h"
#include "common/jobs/task.h"
#include "common/report/job_meshes.h"

namespace cohort {
namespace {

using Json = nlohmann::ordered_json;

Json TimeJson(int64_t unix_ms) {
  return unix_ms == 0 ? Json() : Json(Iso8601Utc(unix_ms));
}

Json MeshJson(const JobMesh& mesh) {
  Json json;
  json["name"] = mesh.mesh.name;
  json["sha256"] = mesh.mesh.raw.Hex();
  json["size_bytes"] = mesh.mesh.size_bytes;
  json["labels"] = mesh.mesh.labels;
  json["status"] = std::string(MeshStatus(mesh));
  if (!mesh.rejection.empty()) json["reason"] = mesh.rejection;
  return json;
}

Json WorkJson(const WorkCounters& work) {
  return {{"index_builds", work.index_builds}, {"lookups", work.lookups}};
}

Json TotalsJson(const Counters& counters) {
  WorkCounters thesis = counters.align;
  thesis += counters.average;
  WorkCounters all = thesis;
  all += counters.pose;
  all += counters.compare;
  all += counters.variation;
  return {{"all_stages", WorkJson(all)},
          {"align_and_average", WorkJson(thesis)},
          {"directed_pairs", counters.pairs}};
}

Json RunJson(const JobJsonInput& input) {
  const Job& job = input.job;
  Json json;
  json["host"] = input.host;
  json["created"] = TimeJson(job.created_unix_ms);
  json["started"] = TimeJson(job.started_unix_ms);
  json["finished"] = TimeJson(job.finished_unix_ms);
  json["seconds"] = nullptr;
  if (job.started_unix_ms != 0 && job.finished_unix_ms != 0) {
    json["seconds"] = static_cast<double>(job.finished_unix_ms - job.started_unix_ms) / 1000;
  }
  json["stages"] = Json::object();
  for (const StageTime& stage : job.progress.stages) {
    json["stages"][stage.name]["seconds"] =
        static_cast<double>(stage.finished_unix_ms - stage.started_unix_ms) / 1000;
  }
  return json;
}

}  // namespace

std::string Iso8601Utc(int64_t unix_ms) {
  using std::chrono::floor;
  const std::chrono::sys_time<std::chrono::milliseconds> time{std::chrono::milliseconds(unix_ms)};
  const auto day = floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ",
                static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()), static_cast<int>(clock.hours().count()),
                static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()),
                static_cast<int>(clock.subseconds().count()));
  return text.data();
}

std::string JobJson(const JobJsonInput& input) {
  const Job& job = input.job;
  Json json;
  json["software"] = input.software_version;
  json["job"] = job.id.value;
  json["set"] = job.set;
  json["state"] = std::string(JobStateName(job.state));
  if (!job.error.empty()) json["error"] = job.error;
  json["parameters"] = Json(ToJson(job.spec));
  json["files"] = Json::array();
  for (const ResultFile& file : input.files) {
    json["files"].push_back(
        {{"name", file.name}, {"description", file.description}, {"unit", file.unit}});
  }
  if (!input.notes.empty()) json["notes"] = input.notes;
  json["counters"] = Json(ToJson(job.counters));
  json["totals"] = TotalsJson(job.counters);
  json["meshes"] = Json::array();
  for (const JobMesh& mesh : input.meshes) json["meshes"].push_back(MeshJson(mesh));
  json["run"] = RunJson(input);
  // File names may be any bytes; what is not UTF-8 is replaced, since JSON cannot say it.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cohort
