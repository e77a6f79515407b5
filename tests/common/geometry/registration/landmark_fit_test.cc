#include "common/geometry/registration/landmark_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::MakeSimilarity;
using testing::StatusIs;

LandmarkSet Face() {
  LandmarkSet set;
  set.names = {"nose", "nasion", "chin", "eye_r", "eye_l"};
  set.points.resize(3, 5);
  set.points << 0, 0, 1, -45, 44,  //
      0, 35, -90, 30, 31,          //
      9, -18, -8, -44, -43;
  return set;
}

LandmarkSet Moved(const LandmarkSet& set, const Similarity& T) {
  return {.names = set.names, .points = T.Apply(set.points)};
}

TEST(FitLandmarks, RecoversAKnownSimilarityFromTheCommonNames) {
  const Similarity truth = MakeSimilarity(1.2, 75, {1, 2, -1}, {30, -4, 100});
  LandmarkSet target = Moved(Face(), truth);
  // Another order, one name more, one less.
  target.names = {"nose", "nasion", "chin", "ear", "eye_l"};
  target.points.col(3).setConstant(1e3);
  target.points.col(0).swap(target.points.col(4));
  std::swap(target.names[0], target.names[4]);
  const auto fit = FitLandmarks(Face(), target, ScaleMode::kFree);
  ASSERT_THAT(fit, IsOk());
  EXPECT_THAT(fit->names, ElementsAre("chin", "eye_l", "nasion", "nose"));
  EXPECT_TRUE(fit->T_target_source.Matrix().isApprox(truth.Matrix(), 1e-12));
  EXPECT_LT(fit->rms, 1e-12);
}

TEST(FitLandmarks, GivesTheResidualOfEachLandmarkAndTheirRms) {
  LandmarkSet target = Face();
  target.points(2, 2) += 4;
  const auto fit = FitLandmarks(Face(), target, ScaleMode::kOff);
  ASSERT_THAT(fit, IsOk());
  double sum = 0;
  for (size_t i = 0; i < fit->names.size(); ++i) {
    const Eigen::Index column = Face().IndexOf(fit->names[i]);
    const double residual =
        (fit->T_target_source.ApplyToPoint(Face().points.col(column)) - target.points.col(column))
            .norm();
    EXPECT_NEAR(fit->residuals(static_cast<Eigen::Index>(i)), residual, 1e-12);
    sum += residual * residual;
  }
  EXPECT_NEAR(fit->rms, std::sqrt(sum / 5), 1e-12);
  EXPECT_GT(fit->rms, 0.1);
  EXPECT_EQ(fit->T_target_source.scale, 1);
}

TEST(FitLandmarks, ListsTheNamesThatAreMissing) {
  const LandmarkSet target = {.names = {"nose", "chin", "ear_l"},
                              .points = Eigen::Matrix3Xd::Random(3, 3)};
  EXPECT_THAT(FitLandmarks(Face(), target, ScaleMode::kOff),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "2 common landmarks, 3 are needed; missing in the source: ear_l; missing "
                       "in the target: eye_l, eye_r, nasion"));
}

TEST(FitLandmarks, RefusesLandmarksOnALine) {
  LandmarkSet line = Face();
  for (Eigen::Index i = 0; i < 5; ++i) {
    line.points.col(i) = static_cast<double>(i) * Eigen::Vector3d(10, 20, -5);
  }
  line.points(0, 2) += 0.01;
  EXPECT_THAT(FitLandmarks(line, Face(), ScaleMode::kOff),
              StatusIs(absl::StatusCode::kFailedPrecondition, "source lie on one line"));
  EXPECT_THAT(FitLandmarks(Face(), line, ScaleMode::kOff),
              StatusIs(absl::StatusCode::kFailedPrecondition, "target lie on one line"));
}

TEST(FitLandmarks, AcceptsThreeLandmarks) {
  const LandmarkSet three = {
      .names = {"nose", "chin", "eye_l"},
      .points = PointsOf(Face(), std::vector<std::string>{"nose", "chin", "eye_l"})};
  const Similarity truth = MakeSimilarity(1, 130, {0, 1, 1}, {1, 2, 3});
  const auto fit = FitLandmarks(three, Moved(Face(), truth), ScaleMode::kOff);
  ASSERT_THAT(fit, IsOk());
  EXPECT_TRUE(fit->T_target_source.Matrix().isApprox(truth.Matrix(), 1e-12));
}

}  // namespace
}  // namespace cohort
