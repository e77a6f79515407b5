#include "common/geometry/mesh/landmark_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

LandmarkSet Numbered(std::vector<std::string> names) {
  LandmarkSet set;
  set.names = std::move(names);
  set.points.resize(3, static_cast<Eigen::Index>(set.names.size()));
  for (Eigen::Index i = 0; i < set.points.cols(); ++i) {
    set.points.col(i).setConstant(static_cast<double>(i));
  }
  return set;
}

TEST(LandmarkSet, FindsALandmarkByItsName) {
  const LandmarkSet set = Numbered({"nasion", "chin"});
  EXPECT_EQ(set.Count(), 2);
  EXPECT_EQ(set.IndexOf("chin"), 1);
  EXPECT_EQ(set.IndexOf("Chin"), -1);
}

TEST(CommonLandmarks, AreThoseOfAllSetsWhateverTheirOrder) {
  const LandmarkSet a = Numbered({"z", "chin", "nasion", "b"});
  const LandmarkSet b = Numbered({"nasion", "b", "z"});
  const LandmarkSet c = Numbered({"b", "q", "z"});
  EXPECT_THAT(CommonLandmarks(std::vector{a, b, c}), ElementsAre("b", "z"));
  EXPECT_THAT(CommonLandmarks(std::vector{c, a, b}), ElementsAre("b", "z"));
  EXPECT_THAT(CommonLandmarks(std::vector{a}), ElementsAre("b", "chin", "nasion", "z"));
  EXPECT_THAT(CommonLandmarks({}), IsEmpty());
}

TEST(PointsOf, FollowsTheOrderOfTheNames) {
  const LandmarkSet set = Numbered({"z", "chin", "nasion"});
  const std::vector<std::string> names = {"nasion", "z"};
  const Eigen::Matrix3Xd points = PointsOf(set, names);
  ASSERT_EQ(points.cols(), 2);
  EXPECT_EQ(points(0, 0), 2);
  EXPECT_EQ(points(0, 1), 0);
}

}  // namespace
}  // namespace cohort
