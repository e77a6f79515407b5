#include "client/evaluation/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::HasSubstr;

Findings SomeFindings() {
  Findings findings;
  findings.tables.push_back({"5.4", "search structures", {"meshes", "a | b"}, {{"x", "20"}}, "20"});
  findings.Check("5.4", PropertyClass::kFormula, "N", "20", "20", true);
  findings.Check("5.9", PropertyClass::kOrdinal, "agrees", "so", "no", false);
  findings.Check("5.8", PropertyClass::kRange, "small", "so", "large", false);
  findings.NotTested("5.7", PropertyClass::kOrdinal, "same person", "no labels");
  return findings;
}

TEST(Findings, CountOnlyWhatMustHoldAsFailures) {
  EXPECT_EQ(CountFailures(SomeFindings()), 1);
}

TEST(Findings, AreOneMarkdownPageWithVerdictsFirst) {
  const std::string page = FindingsMarkdown(SomeFindings(), "# Faces\n");
  EXPECT_THAT(page, HasSubstr("# Faces\n"));
  EXPECT_THAT(page, HasSubstr("| F | 1 | 0 | 0 |"));
  EXPECT_THAT(page, HasSubstr("| O | 0 | 1 | 1 |"));
  EXPECT_THAT(page, HasSubstr("| 5.9 | O | agrees | so | no | DOES NOT HOLD |"));
  EXPECT_THAT(page, HasSubstr("| 5.7 | O | same person |  | no labels | not tested |"));
  EXPECT_THAT(page, HasSubstr("| meshes | a \\| b |\n| --- | --- |\n| x | 20 |"));
  EXPECT_LT(page.find("## Verdicts"), page.find("## 5.4"));
}

TEST(Findings, AreTablesForPrograms) {
  EXPECT_EQ(TableCsv(SomeFindings().tables[0]), "meshes,a | b\r\nx,20\r\n");
  EXPECT_THAT(PropertiesCsv(SomeFindings()), HasSubstr("5.8,R,small,so,large,DOES NOT HOLD\r\n"));
}

}  // namespace
}  // namespace cohort
