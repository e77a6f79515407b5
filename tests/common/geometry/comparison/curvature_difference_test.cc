#include "common/geometry/comparison/curvature_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(CurvatureDifferences, AreAbsoluteAndFollowTheNeighbours) {
  const std::vector<double> source = {0.5, -0.25, 1};
  const std::vector<double> target = {1, 0.75};
  EXPECT_THAT(CurvatureDifferences(source, target, std::vector<int32_t>{1, 0, 0}),
              ::testing::ElementsAre(0.25F, 1.25F, 0.0F));
}

TEST(CurvatureDifferences, OfAMeshWithItselfAreZero) {
  const std::vector<double> curvatures = {0.5, -0.25, 1};
  EXPECT_THAT(CurvatureDifferences(curvatures, curvatures, std::vector<int32_t>{0, 1, 2}),
              ::testing::Each(0.0F));
}

}  // namespace
}  // namespace cohort
