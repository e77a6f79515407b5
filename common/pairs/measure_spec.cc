#include "common/pairs/measure_spec.h"

#include <vector>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

namespace cohort {
namespace {

constexpr double kPercent = 100;

/// "1st", "22nd", "95th", "99.5th".
std::string Ordinal(double number) {
  const std::string text = absl::StrCat(number);
  const bool is_teen = text.size() > 1 && text[text.size() - 2] == '1';
  if (text.find('.') != std::string::npos || is_teen) {
    return text + "th";
  }
  switch (text.back()) {
    case '1':
      return text + "st";
    case '2':
      return text + "nd";
    case '3':
      return text + "rd";
    default:
      return text + "th";
  }
}

}  // namespace

FieldOptions MeasureSpec::ToFieldOptions() const {
  FieldOptions options;
  options.sign = sign;
  options.percentile = percentile.value_or(options.percentile);
  options.lower_share = lower_share;
  options.upper_share = upper_share;
  return options;
}

std::string MeasureSpec::Name() const {
  return percentile ? absl::StrCat("p", *percentile * kPercent) : std::string(MetricName(metric));
}

std::string MeasureSpec::Title() const {
  std::string title = percentile ? Ordinal(*percentile * kPercent) + " percentile of the distances"
                                 : std::string(MetricTitle(metric));
  std::vector<std::string> remarks;
  if (sign == DistanceSign::kSigned) remarks.emplace_back("signed");
  if (by_area) remarks.emplace_back("by area");
  if (ToFieldOptions().HasThresholds()) {
    remarks.push_back(absl::StrCat("from ", lower_share, " to ", upper_share));
  }
  return remarks.empty() ? title : absl::StrCat(title, " (", absl::StrJoin(remarks, ", "), ")");
}

absl::StatusOr<MeasureSpec> ParseMeasure(const std::string& text) {
  MeasureSpec spec;
  if (const std::optional<Metric> metric = MetricFromName(text)) {
    spec.metric = *metric;
    return spec;
  }
  double percent = 0;
  if (text.starts_with('p') && absl::SimpleAtod(text.substr(1), &percent) && percent >= 0 &&
      percent <= kPercent) {
    spec.percentile = percent / kPercent;
    return spec;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("metric \"", text,
                   "\": expected rms, mean, geometric-mean, min, max, variance, or p and a "
                   "percentage from 0 to 100, e.g. p95"));
}

}  // namespace cohort
