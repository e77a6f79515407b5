#include "client/labels_csv.h"

#include <gmock/gmock.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using ::testing::Pair;
using testing::StatusIs;

TEST(ParseLabels, KeepsEveryColumnByFile) {
  const auto labels = ParseLabels("file,person,age\r\na.ply,p1,30\r\nb.ply,p2,\r\n", "l.csv");
  ASSERT_THAT(labels, IsOk());
  EXPECT_THAT(labels->at("a.ply"), ElementsAre(Pair("age", "30"), Pair("person", "p1")));
  EXPECT_THAT(labels->at("b.ply"), ElementsAre(Pair("age", ""), Pair("person", "p2")));
}

TEST(ParseLabels, ReadsQuotesLineBreaksAndUtf8) {
  const auto labels = ParseLabels(
      "\xEF\xBB\xBF\"file\",note\n\"a, \"\"b\"\".ply\",\"two\nlines\"\n\nc.ply,\xC3\xA9\n",
      "l.csv");
  ASSERT_THAT(labels, IsOk());
  EXPECT_EQ(labels->at("a, \"b\".ply").at("note"), "two\nlines");
  EXPECT_EQ(labels->at("c.ply").at("note"), "\xC3\xA9");
}

TEST(ParseLabels, TakesSemicolonsAndAMissingLastLineEnd) {
  const auto labels = ParseLabels("file;person\na.ply;p1", "l.csv");
  ASSERT_THAT(labels, IsOk());
  EXPECT_EQ(labels->at("a.ply").at("person"), "p1");
}

TEST(ParseLabels, NamesFileLineAndReason) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(ParseLabels("", "l.csv"), StatusIs(kBad, "l.csv: is empty"));
  EXPECT_THAT(ParseLabels("file,person\na,\xE9\n", "l.csv"), StatusIs(kBad, "not UTF-8"));
  EXPECT_THAT(ParseLabels("name,person\n", "l.csv"), StatusIs(kBad, "l.csv: line 1: no column"));
  EXPECT_THAT(ParseLabels("file,file\n", "l.csv"), StatusIs(kBad, "unique"));
  EXPECT_THAT(ParseLabels("file,person\na\n", "l.csv"), StatusIs(kBad, "line 2: 1 fields"));
  EXPECT_THAT(ParseLabels("file,p\na,1\na,2\n", "l.csv"), StatusIs(kBad, "line 3: file 'a'"));
  EXPECT_THAT(ParseLabels("file,p\n\"a,1\n", "l.csv"), StatusIs(kBad, "line 2: a quote"));
  EXPECT_THAT(ParseLabels("file,p\n\"a\"b,1\n", "l.csv"), StatusIs(kBad, "closing quote"));
}

}  // namespace
}  // namespace cohort
