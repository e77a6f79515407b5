#include "client/output/estimate_text.h"

#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "client/output/progress_line.h"

namespace cohort {
namespace {

/// Method each is worth a warning if it takes so many times what method average does,
constexpr double kMuchMore = 5;
/// and more than a quarter of an hour of one core.
constexpr double kWorthATalk = 900;

std::string FormatBytes(int64_t bytes) {
  constexpr std::array<const char*, 5> kUnits = {"kB", "MB", "GB", "TB", "PB"};
  double value = static_cast<double>(bytes) / 1000;
  size_t unit = 0;
  while (value >= 1000 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

/// "0.7 s", "4:05", "12.3 core-hours".
std::string FormatCoreTime(double seconds) {
  if (seconds < 60) {
    return fmt::format("{:.1f} s", seconds);
  }
  return seconds < 3600 ? FormatDuration(seconds)
                        : fmt::format("{:.1f} core-hours", seconds / 3600);
}

std::string RateText(double measured_share) {
  if (measured_share >= 0.995) {
    return "by the rates measured on this server";
  }
  if (measured_share <= 0) {
    return "by assumed rates: this server has measured none yet";
  }
  if (measured_share <= 0.005) {
    return "less than 1 % of it by rates measured on this server, the rest assumed";
  }
  return fmt::format("{:.0f} % of it by rates measured on this server, the rest assumed",
                     100 * measured_share);
}

std::string StageLines(const Estimate& estimate) {
  std::string text = fmt::format("{:<14} {:>9}  {:>16}  rate\n", "stage", "tasks", "core time");
  int64_t tasks = 0;
  for (const StageEstimate& stage : estimate.stages) {
    tasks += stage.tasks;
    text +=
        fmt::format("{:<14} {:>9}  {:>16}  {}\n", stage.name, stage.tasks,
                    FormatCoreTime(stage.core_seconds), stage.is_measured ? "measured" : "assumed");
  }
  return text + fmt::format("{:<14} {:>9}  {:>16}  {}\n", "all", tasks,
                            FormatCoreTime(estimate.CoreSeconds()),
                            RateText(estimate.MeasuredShare()));
}

std::string SpaceLines(const Estimate& estimate) {
  std::string text = "written        ";
  for (const auto& [retention, bytes] : estimate.distance_bytes) {
    text += fmt::format("{}{} {}{}", text.back() == ' ' ? "" : ", ", RetentionName(retention),
                        FormatBytes(bytes), retention == estimate.retention ? " (chosen)" : "");
  }
  text += fmt::format("; besides {}\n", FormatBytes(estimate.other_bytes));
  return text + fmt::format("in all         {}{}\n", FormatBytes(estimate.BytesWritten()),
                            estimate.free_bytes ? fmt::format(", the store has room for {}",
                                                              FormatBytes(*estimate.free_bytes))
                                                : "");
}

}  // namespace

std::string EstimateWarnings(const Estimate& estimate) {
  std::string text;
  if (!estimate.Fits()) {
    text += fmt::format(
        "warning: {} do not fit into the store, which has room for {}: choose another --retention "
        "or make space (cohort delete, cohort gc); submit will refuse the job\n",
        FormatBytes(estimate.BytesWritten()), FormatBytes(*estimate.free_bytes));
  }
  const double core_seconds = estimate.CoreSeconds();
  if (estimate.average_core_seconds > 0 && core_seconds > kWorthATalk &&
      core_seconds > kMuchMore * estimate.average_core_seconds) {
    text += fmt::format(
        "warning: method each aligns every pair: {}, {:.0f} times the {} of method average\n",
        FormatCoreTime(core_seconds), core_seconds / estimate.average_core_seconds,
        FormatCoreTime(estimate.average_core_seconds));
  }
  return text;
}

std::string EstimateToText(const Estimate& estimate) {
  std::string text = fmt::format("{} meshes, {} directed pairs\n", estimate.meshes, estimate.pairs);
  text += StageLines(estimate);
  text += estimate.slots > 0
              ? fmt::format("time           about {} with the {} slots of the workers there are\n",
                            FormatDuration(estimate.wall_seconds), estimate.slots)
              : "time           no workers now\n";
  return text + SpaceLines(estimate) + EstimateWarnings(estimate);
}

nlohmann::json EstimateToJson(const Estimate& estimate) {
  nlohmann::json stages = nlohmann::json::array();
  for (const StageEstimate& stage : estimate.stages) {
    stages.push_back({{"name", stage.name},
                      {"tasks", stage.tasks},
                      {"core_seconds", stage.core_seconds},
                      {"measured", stage.is_measured}});
  }
  nlohmann::json distances = nlohmann::json::object();
  for (const auto& [retention, bytes] : estimate.distance_bytes) {
    distances[std::string(RetentionName(retention))] = bytes;
  }
  return {
      {"meshes", estimate.meshes},
      {"pairs", estimate.pairs},
      {"stages", std::move(stages)},
      {"core_seconds", estimate.CoreSeconds()},
      {"measured_share", estimate.MeasuredShare()},
      {"slots", estimate.slots},
      {"wall_seconds",
       estimate.slots > 0 ? nlohmann::json(estimate.wall_seconds) : nlohmann::json()},
      {"retention", RetentionName(estimate.retention)},
      {"distance_bytes", std::move(distances)},
      {"other_bytes", estimate.other_bytes},
      {"bytes_written", estimate.BytesWritten()},
      {"free_bytes", estimate.free_bytes ? nlohmann::json(*estimate.free_bytes) : nlohmann::json()},
      {"fits", estimate.Fits()},
      {"average_core_seconds", estimate.average_core_seconds}};
}

}  // namespace cohort
