#include "common/geometry/comparison/pair_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(RejectBoundaryPairs, DropsNeighboursOnTheRim) {
  const std::vector<uint8_t> boundary = {1, 0, 0, 1};
  const PairMask mask = RejectBoundaryPairs(std::vector<int32_t>{1, 0, 2, 3, 1}, boundary);
  EXPECT_THAT(mask.keep, ElementsAre(1, 0, 1, 0, 1));
  EXPECT_EQ(mask.kept, 3);
}

TEST(RejectBoundaryPairs, KeepsAllOfAClosedSurface) {
  const PairMask mask = RejectBoundaryPairs(std::vector<int32_t>{1, 0}, std::vector<uint8_t>{0, 0});
  EXPECT_EQ(mask.kept, 2);
}

TEST(KeptValues, AreThoseOfTheMaskInOrder) {
  const PairMask mask{.keep = {1, 0, 1}, .kept = 2};
  EXPECT_THAT(KeptValues<float>(std::vector<float>{3, 2, 1}, mask), ElementsAre(3, 1));
  EXPECT_THAT(KeptValues<double>(std::vector<double>{0.3, 0.2, 0.1}, mask), ElementsAre(0.3, 0.1));
}

TEST(KeptValues, MayBeNone) {
  const PairMask mask = RejectBoundaryPairs(std::vector<int32_t>{0, 0}, std::vector<uint8_t>{1});
  EXPECT_EQ(mask.kept, 0);
  EXPECT_THAT(KeptValues<float>(std::vector<float>{1, 2}, mask), IsEmpty());
}

}  // namespace
}  // namespace cohort
