#include "client/name_pattern.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using ::testing::Optional;
using ::testing::Pair;
using testing::StatusIs;

std::optional<std::map<std::string, std::string>> Matched(std::string_view pattern,
                                                          std::string_view name) {
  const auto parsed = NamePattern::Create(pattern);
  EXPECT_THAT(parsed, IsOk());
  return parsed->Match(name);
}

TEST(NamePattern, TakesNamesApart) {
  EXPECT_THAT(Matched("{person}_{session}", "anna_2016_b.ply"),
              Optional(ElementsAre(Pair("person", "anna"), Pair("session", "2016_b"))));
  EXPECT_THAT(Matched("scan-{person}-s{session}-x", "scan-7-s2-x.obj"),
              Optional(ElementsAre(Pair("person", "7"), Pair("session", "2"))));
  EXPECT_THAT(Matched("{person}", "v1.2.ply"), Optional(ElementsAre(Pair("person", "v1.2"))));
  EXPECT_THAT(Matched("{person}", "no_extension"),
              Optional(ElementsAre(Pair("person", "no_extension"))));
}

TEST(NamePattern, DoesNotFitWhatIsOtherwise) {
  EXPECT_EQ(Matched("{person}_{session}", "anna.ply"), std::nullopt);
  EXPECT_EQ(Matched("{person}_{session}", "_2016.ply"), std::nullopt);
  EXPECT_EQ(Matched("{person}_{session}", "anna_.ply"), std::nullopt);
  EXPECT_EQ(Matched("scan{person}", "anna.ply"), std::nullopt);
  EXPECT_EQ(Matched("{person}_neutral", "anna_smile.ply"), std::nullopt);
  EXPECT_EQ(Matched("{person}_neutral", "_neutral.ply"), std::nullopt);
}

TEST(NamePattern, RefusesWhatIsNoPattern) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(NamePattern::Create("person"), StatusIs(kInvalid, "'person': it has no label"));
  EXPECT_THAT(NamePattern::Create("{person"), StatusIs(kInvalid, "not closed"));
  EXPECT_THAT(NamePattern::Create("{person}}"), StatusIs(kInvalid, "not opened"));
  EXPECT_THAT(NamePattern::Create("{a}{b}"), StatusIs(kInvalid, "text between"));
  EXPECT_THAT(NamePattern::Create("{a}_{a}"), StatusIs(kInvalid, "each another one"));
  EXPECT_THAT(NamePattern::Create("{}"), StatusIs(kInvalid, "must have names"));
}

}  // namespace
}  // namespace cohort
