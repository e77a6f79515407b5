#include "common/report/plot_text.h"

#include <gmock/gmock.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

// Every character is one wide.
double CharacterCount(const std::string& text) {
  double count = 0;
  for (const char c : text) count += (static_cast<unsigned char>(c) & 0xC0U) == 0x80U ? 0 : 1;
  return count;
}

TEST(FittedLabels, StayAsTheyAreWhenAllFit) {
  const std::vector<std::string> labels = {"scan_1.ply", "scan_2.ply"};
  EXPECT_THAT(FittedLabels(labels, 10, CharacterCount), ElementsAre("scan_1.ply", "scan_2.ply"));
}

TEST(FittedLabels, LoseFirstWhatAllHaveInCommon) {
  const std::vector<std::string> labels = {"university_study_007_a_neutral.ply",
                                           "university_study_013_b_neutral.ply"};
  EXPECT_THAT(FittedLabels(labels, 12, CharacterCount), ElementsAre("…007_a…", "…013_b…"));
}

TEST(FittedLabels, LoseTheirMiddleWhenStillTooLong) {
  const std::vector<std::string> labels = {"abcdefghijklmno", "1234567890"};
  EXPECT_THAT(FittedLabels(labels, 7, CharacterCount), ElementsAre("abc…mno", "123…890"));
}

TEST(FittedLabels, AreNotCutWithinACharacter) {
  // š and ť share their first byte, so the common beginning ends before it.
  const std::vector<std::string> labels = {"common_š_long_enough_x", "common_ť_long_enough_x"};
  EXPECT_THAT(FittedLabels(labels, 10, CharacterCount), ElementsAre("…š…", "…ť…"));
  const std::vector<std::string> one = {"ššššššššššš"};
  EXPECT_THAT(FittedLabels(one, 5, CharacterCount), ElementsAre("šš…šš"));
}

TEST(FittedLabels, SurviveEqualAndEmptyLabels) {
  const std::vector<std::string> labels = {"the_same_long_name", "the_same_long_name"};
  EXPECT_THAT(FittedLabels(labels, 5, CharacterCount), ElementsAre("…", "…"));
  const std::vector<std::string> empty = {"", "a_long_name"};
  EXPECT_THAT(FittedLabels(empty, 3, CharacterCount), ElementsAre("", "a…e"));
  const std::vector<std::string> tiny = {"abc"};
  EXPECT_THAT(FittedLabels(tiny, 0, CharacterCount), ElementsAre("…"));
}

}  // namespace
}  // namespace cohort
