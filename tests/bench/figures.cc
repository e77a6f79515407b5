#include "tests/bench/figures.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

namespace cohort {
namespace {

std::string GoalText(const Figure& figure) {
  switch (figure.goal.kind) {
    case Goal::Kind::kAtLeast:
      return absl::StrCat(">= ", Digits(figure.goal.value), figure.unit);
    case Goal::Kind::kAtMost:
      return absl::StrCat("<= ", Digits(figure.goal.value), figure.unit);
    case Goal::Kind::kNone:
      break;
  }
  return "";
}

std::string Verdict(const Figure& figure) {
  if (!figure.value.has_value() || figure.goal.kind == Goal::Kind::kNone) {
    return "";
  }
  return figure.FallsShort() ? "**short**" : "yes";
}

/// The different values of a member, in order of first appearance.
std::vector<std::string> Distinct(const std::vector<RivalTime>& times, std::string RivalTime::*of) {
  std::vector<std::string> values;
  for (const RivalTime& time : times) {
    if (std::find(values.begin(), values.end(), time.*of) == values.end()) {
      values.push_back(time.*of);
    }
  }
  return values;
}

}  // namespace

std::string Digits(double value) {
  const double size = std::abs(value);
  if (size != 0 && (size < 1e-3 || size >= 1e7)) {
    return absl::StrFormat("%.1e", value);
  }
  return absl::StrFormat("%.*f", size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 ? 2 : 4, value);
}

bool Figure::FallsShort() const {
  if (!value.has_value()) {
    return false;
  }
  switch (goal.kind) {
    case Goal::Kind::kAtLeast:
      return !(*value >= goal.value);  // also for NaN
    case Goal::Kind::kAtMost:
      return !(*value <= goal.value);
    case Goal::Kind::kNone:
      break;
  }
  return false;
}

std::string FigureTable::Markdown() const {
  std::string text =
      "| figure, one core | must reach | reached | holds | measured |\n"
      "|---|---|---|---|---|\n";
  for (const Figure& figure : figures_) {
    const std::string value =
        figure.value.has_value() ? absl::StrCat(Digits(*figure.value), figure.unit) : "-";
    absl::StrAppend(&text, "| ", figure.name, " | ", GoalText(figure), " | ", value, " | ",
                    Verdict(figure), " | ", figure.note, " |\n");
  }
  return text + RivalMarkdown();
}

std::string FigureTable::RivalMarkdown() const {
  if (rivals_.empty()) {
    return "";
  }
  const std::vector<std::string> columns = Distinct(rivals_, &RivalTime::column);
  std::string text = "\n| ns a query (times Cohort's) |";
  std::string rule = "\n|---|";
  for (const std::string& column : columns) {
    absl::StrAppend(&text, " ", column, " |");
    rule += "---|";
  }
  text += rule;
  for (const std::string& rival : Distinct(rivals_, &RivalTime::rival)) {
    absl::StrAppend(&text, "\n| ", rival, " |");
    for (const std::string& column : columns) {
      const auto found = std::find_if(rivals_.begin(), rivals_.end(), [&](const RivalTime& t) {
        return t.rival == rival && t.column == column;
      });
      absl::StrAppend(&text, " ",
                      found == rivals_.end() ? ""
                                             : absl::StrCat(Digits(found->nanoseconds), " (",
                                                            Digits(found->ratio), " x)"),
                      " |");
    }
  }
  return text + "\n";
}

std::vector<std::string> FigureTable::Shortfalls() const {
  std::vector<std::string> lines;
  for (const Figure& figure : figures_) {
    if (figure.FallsShort()) {
      lines.push_back(absl::StrCat(figure.name, ": reached ", Digits(*figure.value), figure.unit,
                                   ", must be ", GoalText(figure)));
    }
  }
  return lines;
}

}  // namespace cohort
