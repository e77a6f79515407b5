#pragma once

#include <string>
#include <vector>

namespace cohort {

/// A table of the thesis's chapter 5 (or the numbers of a figure), filled with ours.
struct EvaluationTable {
  std::string item;   ///< "5.1"; for figures "figure 5.6".
  std::string title;  ///< One line.
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::string thesis;  ///< The thesis's own values, in words; empty: it has none.
};

/// How binding a property is. Source: predecessor.md (d).
enum class PropertyClass {
  kFormula,  ///< F: exact, must hold to the unit.
  kOrdinal,  ///< O: must hold on any reasonable set of faces.
  kRange,    ///< R: typical for faces; reported, not required.
};

enum class Verdict { kHolds, kFails, kNotTested };

/// What the thesis found, and whether it is so here.
struct Property {
  std::string item;
  PropertyClass kind = PropertyClass::kOrdinal;
  std::string claim;   ///< What must hold.
  std::string thesis;  ///< What the thesis saw.
  std::string seen;    ///< Our numbers; why it was not tested.
  Verdict verdict = Verdict::kNotTested;
};

/// A picture: a PNG file's name and bytes.
struct EvaluationPicture {
  std::string name;
  std::string description;
  std::string png;
};

struct Findings {
  std::vector<EvaluationTable> tables;
  std::vector<Property> properties;
  std::vector<EvaluationPicture> pictures;

  void Check(const std::string& item,
             PropertyClass kind,
             const std::string& claim,
             const std::string& thesis,
             const std::string& seen,
             bool holds) {
    properties.push_back(
        {item, kind, claim, thesis, seen, holds ? Verdict::kHolds : Verdict::kFails});
  }
  void NotTested(const std::string& item,
                 PropertyClass kind,
                 const std::string& claim,
                 const std::string& why) {
    properties.push_back({item, kind, claim, "", why, Verdict::kNotTested});
  }
};

[[nodiscard]] char ClassLetter(PropertyClass kind);      ///< 'F', 'O', 'R'.
[[nodiscard]] std::string VerdictText(Verdict verdict);  ///< "holds", "DOES NOT HOLD", ...

/// The report: verdicts first, then every table. Markdown (GitHub's).
[[nodiscard]] std::string FindingsMarkdown(const Findings& findings, const std::string& heading);
/// "item,class,claim,thesis,seen,verdict".
[[nodiscard]] std::string PropertiesCsv(const Findings& findings);
[[nodiscard]] std::string TableCsv(const EvaluationTable& table);
/// Properties of class F or O that do not hold.
[[nodiscard]] int CountFailures(const Findings& findings);

}  // namespace cohort
