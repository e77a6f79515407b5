#include "client/output/job_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/output/progress_line.h"
#include "common/report/job_json.h"

namespace cohort {
namespace {

constexpr size_t kShownRejections = 10;

int PercentDone(const Job& job) {
  if (job.state == JobState::kSucceeded) {
    return 100;
  }
  const Progress& progress = job.progress;
  return progress.cost_total > 0
             ? static_cast<int>(std::min(1.0, progress.cost_done / progress.cost_total) * 100)
             : 0;
}

std::string Duration(const Job& job) {
  if (job.started_unix_ms == 0 || job.finished_unix_ms == 0) {
    return "-";
  }
  return FormatDuration(static_cast<double>(job.finished_unix_ms - job.started_unix_ms) / 1000);
}

nlohmann::json TimeOrNull(int64_t unix_ms) {
  return unix_ms == 0 ? nlohmann::json() : nlohmann::json(Iso8601Utc(unix_ms));
}

}  // namespace

nlohmann::json JobToJson(const Job& job) {
  return {
      {"id", job.id.value},
      {"set", job.set},
      {"state", JobStateName(job.state)},
      {"error", job.error},
      {"meshes", job.meshes},
      {"rejected_meshes", job.rejected_meshes},
      {"stage", job.progress.stage},
      {"tasks_done", job.progress.tasks_done},
      {"tasks_total", job.progress.tasks_total},
      {"tasks_reused", job.progress.tasks_reused},
      {"tasks_given_up", job.progress.tasks_given_up},
      {"percent", PercentDone(job)},
      {"waiting_for", job.progress.waiting_for},
      {"created", TimeOrNull(job.created_unix_ms)},
      {"started", TimeOrNull(job.started_unix_ms)},
      {"finished", TimeOrNull(job.finished_unix_ms)},
      {"parameters", ToJson(job.spec)},
      {"counters", ToJson(job.counters)},
  };
}

std::string JobToText(const Job& job) {
  std::string text =
      fmt::format("{}  {}  {} %", job.id.value, JobStateName(job.state), PercentDone(job));
  if (!IsFinal(job.state) && !job.progress.stage.empty()) {
    text += fmt::format("  stage {}, {}/{} tasks", job.progress.stage, job.progress.tasks_done,
                        job.progress.tasks_total);
  }
  text += fmt::format("\n  set {}, {} meshes", job.set, job.meshes);
  if (job.rejected_meshes > 0) {
    text += fmt::format(" ({} rejected)", job.rejected_meshes);
  }
  text += fmt::format(", method {}, metric {}{}{}\n", MethodName(job.spec.method),
                      MetricName(job.spec.metric),
                      job.spec.compare.sign == DistanceSign::kSigned ? " (signed)" : "",
                      job.spec.arithmetic == Arithmetic::kFidentis ? ", preset fidentis" : "");
  text += fmt::format("  created {}, took {}\n", Iso8601Utc(job.created_unix_ms), Duration(job));
  if (job.progress.tasks_reused > 0) {
    text += fmt::format("  {} of {} tasks were known from earlier jobs\n",
                        job.progress.tasks_reused, job.progress.tasks_total);
  }
  if (job.progress.tasks_given_up > 0) {
    text += fmt::format("  {} tasks failed; once the job has ended: cohort retry {}\n",
                        job.progress.tasks_given_up, job.id.value);
  }
  if (!job.progress.waiting_for.empty()) {
    text += "  waiting: " + job.progress.waiting_for + "\n";
  }
  if (!job.error.empty()) {
    text += "  error: " + job.error + "\n";
  }
  return text;
}

std::string JobsToTable(const std::vector<Job>& jobs) {
  std::string table = fmt::format("{:<10} {:<10} {:>5} {:>7} {:<8} {:>9}  {:<24} {}\n", "job",
                                  "state", "done", "meshes", "method", "took", "created", "set");
  for (const Job& job : jobs) {
    table += fmt::format("{:<10} {:<10} {:>3} % {:>7} {:<8} {:>9}  {:<24} {}\n", job.id.value,
                         JobStateName(job.state), PercentDone(job), job.meshes,
                         MethodName(job.spec.method), Duration(job),
                         Iso8601Utc(job.created_unix_ms), job.set);
  }
  return table;
}

std::string ResultsToText(const ResultsDigest& results, const std::string& folder) {
  std::string text;
  size_t shown = 0;
  for (const JobMesh& mesh : results.meshes) {
    if (!mesh.rejection.empty() && ++shown <= kShownRejections) {
      text += "rejected: " + mesh.rejection + "\n";
    }
  }
  if (shown > kShownRejections) {
    text += fmt::format("... and {} more; see meshes.csv\n", shown - kShownRejections);
  }
  const auto used = static_cast<int64_t>(results.meshes.size()) - static_cast<int64_t>(shown);
  text += fmt::format("{}: {} of {} meshes compared, {} directed pairs, {}\n", results.job.id.value,
                      used, results.meshes.size(), used * used, Duration(results.job));
  if (results.with_same_person > 0) {
    text += fmt::format("nearest mesh is the same person: {} of {}\n", results.nearest_same_person,
                        results.with_same_person);
  }
  for (const std::string& note : results.notes) {
    text += "note: " + note + "\n";
  }
  text += "results are in " + folder + "\n";
  const bool has_neighbours = results.job.spec.compare.sign == DistanceSign::kAbsolute;
  const bool has_report =
      std::find(results.files.begin(), results.files.end(), "report.html") != results.files.end();
  text += std::string("  look first at ") + (has_report ? "report.html, " : "") +
          "heatmap.png, matrix.csv, " + (has_neighbours ? "neighbours.csv, " : "") +
          "mean_shape.ply\n";
  return text;
}

nlohmann::json ResultsToJson(const ResultsDigest& results, const std::string& folder) {
  nlohmann::json rejected = nlohmann::json::array();
  for (const JobMesh& mesh : results.meshes) {
    if (!mesh.rejection.empty()) {
      rejected.push_back({{"file", mesh.mesh.name}, {"reason", mesh.rejection}});
    }
  }
  return {{"job", JobToJson(results.job)},
          {"folder", folder},
          {"files", results.files},
          {"notes", results.notes},
          {"rejected", rejected},
          {"nearest_same_person", results.nearest_same_person},
          {"with_same_person", results.with_same_person}};
}

}  // namespace cohort
