#include "server/core/task_rates.h"

#include <absl/strings/str_cat.h>

#include "server/core/coordinator_figures.h"

namespace cohort {
namespace {

constexpr double kKept = 0.995;  ///< Of what was, with every new task.

}  // namespace

void TaskRates::Note(const std::string& kind, double cost, double seconds) {
  if (!(cost > 0) || !(seconds >= 0)) {
    return;
  }
  Sums& sums = sums_[kind];
  // Sums, not ratios, are averaged: a short task says less than a long one.
  sums.cost = kKept * sums.cost + cost;
  sums.seconds = kKept * sums.seconds + seconds;
}

std::optional<double> TaskRates::RateOf(const std::string& kind) const {
  const auto found = sums_.find(kind);
  if (found == sums_.end()) {
    return std::nullopt;
  }
  return found->second.seconds / found->second.cost;
}

std::string TaskRates::KindOf(const JobSpec& spec, const std::string& stage) {
  std::string kind(StageKind(stage));
  if (kind == "compare" && spec.method == Method::kEach) {
    kind = "align and compare";
  }
  const bool aligns = kind.rfind("align", 0) == 0;
  if (aligns || kind == "variation" || kind == "symmetrize") {
    absl::StrAppend(&kind, ", ", std::string(CorrespondenceName(spec.icp.correspondence)));
  }
  if (aligns) {
    absl::StrAppend(&kind, ", ", std::string(AccelerationName(spec.icp.acceleration)), ", ",
                    std::string(UndersamplingName(spec.undersampling.method)));
  }
  if (kind == "compare" || kind.rfind("align and", 0) == 0) {
    absl::StrAppend(&kind, ", ", std::string(CorrespondenceName(spec.compare.correspondence)));
  }
  return absl::StrCat(kind, ", ", std::string(ArithmeticName(spec.arithmetic)));
}

}  // namespace cohort
