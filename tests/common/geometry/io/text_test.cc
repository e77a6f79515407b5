#include "common/geometry/io/text.h"

#include <clocale>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> LinesOf(std::string_view text) {
  std::vector<std::string> lines;
  LineReader reader(text);
  std::string_view line;
  while (reader.Next(line)) {
    lines.emplace_back(line);
  }
  return lines;
}

double NumberOf(std::string_view word) {
  double value = -999;
  EXPECT_TRUE(ParseNumber(word, value)) << word;
  return value;
}

bool IsNumber(std::string_view word) {
  double value = 0;
  return ParseNumber(word, value);
}

TEST(LineReader, KnowsAllThreeLineEnds) {
  EXPECT_THAT(LinesOf("a\nb\r\nc\rd"), ElementsAre("a", "b", "c", "d"));
}

TEST(LineReader, GivesEmptyLinesButNoneAfterTheLastEnd) {
  EXPECT_THAT(LinesOf("\n\r\n\ra\n"), ElementsAre("", "", "", "a"));
  EXPECT_THAT(LinesOf(""), ElementsAre());
}

TEST(LineReader, CountsFromTheGivenLine) {
  LineReader reader("a\r\nb", 7);
  std::string_view line;
  ASSERT_TRUE(reader.Next(line));
  EXPECT_EQ(reader.LineNumber(), 7);
  EXPECT_EQ(reader.Offset(), 3U);
  EXPECT_EQ(reader.Remaining(), 1U);
}

TEST(NextWord, SplitsAtBlanksAndTabs) {
  std::string_view rest = " \t v\t1  2";
  EXPECT_EQ(NextWord(rest), "v");
  EXPECT_EQ(NextWord(rest), "1");
  EXPECT_EQ(NextWord(rest), "2");
  EXPECT_EQ(NextWord(rest), "");
  EXPECT_EQ(NextWord(rest), "");
}

TEST(ParseNumber, TakesEverySpellingProgramsWrite) {
  EXPECT_EQ(NumberOf(".5"), 0.5);
  EXPECT_EQ(NumberOf("5."), 5);
  EXPECT_EQ(NumberOf("+.5"), 0.5);
  EXPECT_EQ(NumberOf("-5.e1"), -50);
  EXPECT_EQ(NumberOf("1E+2"), 100);
  EXPECT_EQ(NumberOf("1e-3"), 0.001);
  EXPECT_EQ(NumberOf("-0"), 0);
  EXPECT_EQ(NumberOf("0.1"), 0.1);
}

TEST(ParseNumber, TakesNumbersTooSmallForADoubleAsZero) {
  EXPECT_EQ(NumberOf("1e-400"), 0);
  EXPECT_EQ(NumberOf("-0." + std::string(400, '0') + "1"), 0);
}

TEST(ParseNumber, RefusesWhatIsNoFiniteNumber) {
  for (const char* word : {"", "+", "-", ".", "e5", "1e", "1,5", "0x10", "1 ", "1a", "+-1", "++1",
                           "nan", "-nan", "inf", "Infinity", "1e400", "-1e999", "1.#QNAN"}) {
    EXPECT_FALSE(IsNumber(word)) << word;
  }
}

TEST(ParseNumber, DoesNotDependOnTheLocale) {
  // Not installed everywhere; where it is, strtod would now want a comma.
  const char* const locale = std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(NumberOf("1.5"), 1.5);
  EXPECT_FALSE(IsNumber("1,5"));
  if (locale != nullptr) {
    std::setlocale(LC_ALL, "C");
  }
}

TEST(ParseInteger, TakesSignsAndNothingElse) {
  int64_t value = 0;
  EXPECT_TRUE(ParseInteger("+7", value));
  EXPECT_EQ(value, 7);
  EXPECT_TRUE(ParseInteger("-7", value));
  EXPECT_EQ(value, -7);
  for (const char* word : {"", "+", "7.0", "1e3", "9223372036854775808", "7/"}) {
    EXPECT_FALSE(ParseInteger(word, value)) << word;
  }
}

TEST(EqualIgnoringCase, ComparesWholeWords) {
  EXPECT_TRUE(EqualIgnoringCase("SoLiD", "solid"));
  EXPECT_FALSE(EqualIgnoringCase("solids", "solid"));
  EXPECT_FALSE(EqualIgnoringCase("", "solid"));
}

TEST(Quoted, ShortensAndEscapes) {
  EXPECT_EQ(Quoted("abc"), "'abc'");
  EXPECT_EQ(Quoted(std::string_view("\x01\n", 2)), "'\\x01\\n'");
  EXPECT_EQ(Quoted(std::string(1000, 'a')), "'" + std::string(40, 'a') + "...'");
}

}  // namespace
}  // namespace cohort
