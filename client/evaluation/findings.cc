#include "client/evaluation/findings.h"

#include <algorithm>
#include <array>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_replace.h>

#include "common/report/csv.h"

namespace cohort {
namespace {

/// A cell: bars would end it.
std::string Cell(const std::string& text) {
  return absl::StrReplaceAll(text, {{"|", "\\|"}, {"\n", " "}});
}

std::string Row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) {
    absl::StrAppend(&row, " ", Cell(cell), " |");
  }
  return row + "\n";
}

std::string TableMarkdown(const std::vector<std::string>& columns,
                          const std::vector<std::vector<std::string>>& rows) {
  std::string text = Row(columns);
  text += Row(std::vector<std::string>(columns.size(), "---"));
  for (const auto& row : rows) {
    text += Row(row);
  }
  return text;
}

int CountVerdicts(const Findings& findings, PropertyClass kind, Verdict verdict) {
  return static_cast<int>(
      std::count_if(findings.properties.begin(), findings.properties.end(),
                    [&](const Property& p) { return p.kind == kind && p.verdict == verdict; }));
}

}  // namespace

char ClassLetter(PropertyClass kind) {
  switch (kind) {
    case PropertyClass::kFormula:
      return 'F';
    case PropertyClass::kOrdinal:
      return 'O';
    case PropertyClass::kRange:
      return 'R';
  }
  return '?';
}

std::string VerdictText(Verdict verdict) {
  switch (verdict) {
    case Verdict::kHolds:
      return "holds";
    case Verdict::kFails:
      return "DOES NOT HOLD";
    case Verdict::kNotTested:
      return "not tested";
  }
  return "";
}

std::string FindingsMarkdown(const Findings& findings, const std::string& heading) {
  std::string text = heading + "\n## Verdicts\n\n";
  text +=
      "F: exact formula. O: must hold on any reasonable set of faces. R: typical for faces, told "
      "and not required.\n\n";
  std::vector<std::vector<std::string>> rows;
  for (const PropertyClass kind :
       {PropertyClass::kFormula, PropertyClass::kOrdinal, PropertyClass::kRange}) {
    rows.push_back({std::string(1, ClassLetter(kind)),
                    absl::StrCat(CountVerdicts(findings, kind, Verdict::kHolds)),
                    absl::StrCat(CountVerdicts(findings, kind, Verdict::kFails)),
                    absl::StrCat(CountVerdicts(findings, kind, Verdict::kNotTested))});
  }
  text += TableMarkdown({"class", "hold", "do not hold", "not tested"}, rows) + "\n";
  rows.clear();
  for (const Property& property : findings.properties) {
    rows.push_back({property.item, std::string(1, ClassLetter(property.kind)), property.claim,
                    property.thesis, property.seen, VerdictText(property.verdict)});
  }
  text += TableMarkdown({"item", "class", "claim", "thesis", "here", "verdict"}, rows);
  for (const EvaluationTable& table : findings.tables) {
    absl::StrAppend(&text, "\n## ", table.item, ": ", table.title, "\n\n",
                    TableMarkdown(table.columns, table.rows));
    if (!table.thesis.empty()) {
      absl::StrAppend(&text, "\nThesis: ", table.thesis, "\n");
    }
  }
  for (const EvaluationPicture& picture : findings.pictures) {
    absl::StrAppend(&text, "\n![", picture.description, "](", picture.name, ")\n");
  }
  return text;
}

std::string PropertiesCsv(const Findings& findings) {
  std::string csv =
      CsvRow(std::array<std::string, 6>{"item", "class", "claim", "thesis", "here", "verdict"});
  for (const Property& property : findings.properties) {
    csv += CsvRow(std::array<std::string, 6>{
        property.item, std::string(1, ClassLetter(property.kind)), property.claim, property.thesis,
        property.seen, VerdictText(property.verdict)});
  }
  return csv;
}

std::string TableCsv(const EvaluationTable& table) {
  std::string csv = CsvRow(table.columns);
  for (const auto& row : table.rows) {
    csv += CsvRow(row);
  }
  return csv;
}

int CountFailures(const Findings& findings) {
  return CountVerdicts(findings, PropertyClass::kFormula, Verdict::kFails) +
         CountVerdicts(findings, PropertyClass::kOrdinal, Verdict::kFails);
}

}  // namespace cohort
