#include "common/analysis/group_distances.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::StatusIs;

TEST(SummarizeGroups, TellsWithinFromBetween) {
  MetricMatrix matrix;
  matrix.labels = {"a", "b", "c", "d"};
  matrix.values.resize(4, 4);
  matrix.values << 0, 1, 4, 6,  //
      1, 0, 5, 7,               //
      4, 5, 0, 2,               //
      6, 7, 2, 0;
  const auto ours = SummarizeGroups(matrix, std::vector<std::string>{"x", "x", "y", "y"});
  ASSERT_TRUE(ours.ok()) << ours.status();
  EXPECT_THAT(ours->groups, ElementsAre("x", "y"));
  EXPECT_THAT(ours->sizes, ElementsAre(2, 2));
  ASSERT_EQ(ours->pairs.size(), 3U);
  EXPECT_EQ(ours->pairs[0].values.mean, 1);
  EXPECT_TRUE(std::isnan(ours->pairs[0].values.deviation)) << "of one pair";
  const PairSummary& between = ours->pairs[1].values;
  EXPECT_EQ(ours->pairs[1].first + ours->pairs[1].second, "xy");
  EXPECT_EQ(between.pairs, 4);
  EXPECT_EQ(between.mean, 5.5);
  EXPECT_EQ(between.median, 5.5);
  EXPECT_EQ(between.least, 4);
  EXPECT_EQ(between.largest, 7);
  EXPECT_DOUBLE_EQ(between.deviation, std::sqrt(5.0 / 3));
  EXPECT_EQ(ours->within.pairs, 2);
  EXPECT_EQ(ours->within.mean, 1.5);
  EXPECT_EQ(ours->between.mean, 5.5);
}

TEST(SummarizeGroups, LeavesOutWhatIsUnknownOrMissing) {
  MetricMatrix matrix = RandomDistances(4, 2, 1);
  matrix.values(0, 1) = matrix.values(1, 0) = std::numeric_limits<double>::quiet_NaN();
  const auto ours = SummarizeGroups(matrix, std::vector<std::string>{"x", "x", "y", ""});
  ASSERT_TRUE(ours.ok()) << ours.status();
  EXPECT_EQ(ours->within.pairs, 0);
  EXPECT_EQ(ours->within.missing, 1);
  EXPECT_TRUE(std::isnan(ours->within.mean));
  EXPECT_EQ(ours->between.pairs, 2);
  EXPECT_EQ(ours->pairs[2].values.pairs, 0) << "y has one mesh";
}

TEST(SummarizeGroups, RefusesOneGroup) {
  EXPECT_THAT(SummarizeGroups(RandomDistances(3, 2, 1), std::vector<std::string>{"x", "", "x"}),
              StatusIs(absl::StatusCode::kInvalidArgument, "all meshes are of one group, x"));
}

}  // namespace
}  // namespace cohort
