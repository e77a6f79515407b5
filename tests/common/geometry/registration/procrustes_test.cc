#include "common/geometry/registration/procrustes.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <absl/strings/str_cat.h>

#include "common/geometry/registration/similarity.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::RandomRotation;
using testing::StatusIs;

constexpr double kRounding = 1e-12;

LandmarkSet RandomSet(Eigen::Index count, uint64_t seed) {
  Random random(seed);
  LandmarkSet set;
  set.points.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    set.names.push_back(absl::StrCat("p", i));
    set.points.col(i) << random.Uniform(-60, 60), random.Uniform(-80, 80), random.Uniform(-30, 30);
  }
  return set;
}

Similarity RandomSimilarity(Random& random, double scale) {
  Similarity T;
  T.scale = scale;
  T.rotation = RandomRotation(random);
  T.translation << random.Uniform(-200, 200), random.Uniform(-200, 200), random.Uniform(-200, 200);
  return T;
}

/// Noisy copies of one set, each in a pose and size of its own.
std::vector<LandmarkSet> Variants(int count, double noise) {
  Random random(11);
  std::vector<LandmarkSet> sets(static_cast<size_t>(count), RandomSet(12, 1));
  for (LandmarkSet& set : sets) {
    for (double& value : set.points.reshaped()) {
      value += noise * random.Normal();
    }
    set.points = RandomSimilarity(random, random.Uniform(0.7, 1.4)).Apply(set.points);
  }
  return sets;
}

double CentroidSizeOf(const Eigen::Matrix3Xd& points) {
  return (points.colwise() - points.rowwise().mean()).norm();
}

TEST(Procrustes, OfCopiesInAnyPoseAndSizeIsZero) {
  const std::vector<LandmarkSet> sets = Variants(6, 0);
  const auto analysis = AnalyzeProcrustes(sets, {});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_TRUE(analysis->converged);
  EXPECT_LT(analysis->distances.maxCoeff(), 1e-7);  // the root of a rounding
  EXPECT_LT(analysis->distances_to_mean.maxCoeff(), 1e-7);
  for (size_t s = 0; s < sets.size(); ++s) {
    EXPECT_NEAR(analysis->centroid_sizes(static_cast<Eigen::Index>(s)),
                CentroidSizeOf(sets[s].points), 1e-9);
  }
  EXPECT_NEAR(CentroidSizeOf(analysis->consensus), 1, kRounding);
}

TEST(Procrustes, OfTwoSetsWithTheirSizesIsFitSimilarity) {
  const std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 2)};
  ProcrustesOptions options;
  options.size = ProcrustesSize::kKept;
  const auto analysis = AnalyzeProcrustes(sets, options);
  ASSERT_THAT(analysis, IsOk());
  const auto T = FitSimilarity(sets[0].points, sets[1].points, ScaleMode::kOff);
  ASSERT_THAT(T, IsOk());
  const double distance = (T->Apply(sets[0].points) - sets[1].points).norm();
  EXPECT_NEAR(analysis->distances(0, 1), distance, 1e-10);
  // The mean lies halfway.
  EXPECT_NEAR(analysis->distances_to_mean(0), distance / 2, 1e-6);
  EXPECT_NEAR(analysis->distances_to_mean(1), distance / 2, 1e-6);
}

TEST(Procrustes, OfTwoNormalizedSetsIsTheSymmetricFitInUnitsOfTheTargetsSize) {
  const std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 2)};
  const auto analysis = AnalyzeProcrustes(sets, {});
  ASSERT_THAT(analysis, IsOk());
  const auto T = FitSimilarity(sets[0].points, sets[1].points, ScaleMode::kSymmetric);
  ASSERT_THAT(T, IsOk());
  EXPECT_NEAR(analysis->distances(0, 1),
              (T->Apply(sets[0].points) - sets[1].points).norm() / analysis->centroid_sizes(1),
              kRounding);
}

TEST(Procrustes, NeverReflects) {
  std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 1)};
  sets[1].points.row(0) *= -1;
  const auto analysis = AnalyzeProcrustes(sets, {});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_GT(analysis->distances(0, 1), 0.1);
}

TEST(Procrustes, DoesNotDependOnTheOrderOfTheSets) {
  const std::vector<LandmarkSet> sets = Variants(7, 4);
  const std::vector<LandmarkSet> reversed(sets.rbegin(), sets.rend());
  const auto analysis = AnalyzeProcrustes(sets, {});
  const auto of_reversed = AnalyzeProcrustes(reversed, {});
  ASSERT_THAT(analysis, IsOk());
  ASSERT_THAT(of_reversed, IsOk());
  EXPECT_TRUE(analysis->consensus.isApprox(of_reversed->consensus, 1e-8));
  EXPECT_TRUE(analysis->distances.isApprox(of_reversed->distances.reverse(), kRounding));
  EXPECT_TRUE(analysis->distances_to_mean.isApprox(of_reversed->distances_to_mean.reverse(), 1e-8));
  EXPECT_EQ(analysis->names, of_reversed->names);
}

TEST(Procrustes, DoesNotDependOnPosesAndSizes) {
  const std::vector<LandmarkSet> sets = Variants(5, 4);
  std::vector<LandmarkSet> moved = sets;
  Random random(5);
  for (LandmarkSet& set : moved) {
    set.points = RandomSimilarity(random, random.Uniform(0.1, 10)).Apply(set.points);
  }
  const auto analysis = AnalyzeProcrustes(sets, {});
  const auto of_moved = AnalyzeProcrustes(moved, {});
  ASSERT_THAT(analysis, IsOk());
  ASSERT_THAT(of_moved, IsOk());
  EXPECT_TRUE(analysis->distances.isApprox(of_moved->distances, 1e-9));
  EXPECT_TRUE(analysis->distances_to_mean.isApprox(of_moved->distances_to_mean, 1e-8));
}

TEST(Procrustes, RestsAtTheMeanOfTheSetsAsSuperimposed) {
  const std::vector<LandmarkSet> sets = Variants(9, 5);
  ProcrustesOptions options;
  options.size = ProcrustesSize::kKept;
  const auto analysis = AnalyzeProcrustes(sets, options);
  ASSERT_THAT(analysis, IsOk());
  EXPECT_TRUE(analysis->converged);
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, 12);
  for (const Eigen::Matrix3Xd& configuration : analysis->aligned) {
    mean += configuration / 9;
  }
  EXPECT_TRUE(mean.isApprox(analysis->consensus, 1e-8));
  EXPECT_LT(mean.rowwise().mean().norm(), 1e-9);
  for (size_t s = 0; s < sets.size(); ++s) {
    const auto T = FitSimilarity(analysis->aligned[s], analysis->consensus, ScaleMode::kOff);
    ASSERT_THAT(T, IsOk());
    EXPECT_TRUE(T->rotation.isIdentity(1e-7)) << s;  // no set can be turned any nearer
  }
}

TEST(Procrustes, NoOtherConsensusIsNearer) {
  const std::vector<LandmarkSet> sets = Variants(6, 5);
  ProcrustesOptions options;
  options.size = ProcrustesSize::kKept;
  const auto analysis = AnalyzeProcrustes(sets, options);
  ASSERT_THAT(analysis, IsOk());
  const auto cost = [&sets](const Eigen::Matrix3Xd& consensus) {
    double sum = 0;
    for (const LandmarkSet& set : sets) {
      const Eigen::Matrix3Xd points = PointsOf(set, CommonLandmarks(sets));
      const auto T = FitSimilarity(points, consensus, ScaleMode::kOff);
      sum += (T->Apply(points) - consensus).squaredNorm();
    }
    return sum;
  };
  const double least = cost(analysis->consensus);
  EXPECT_NEAR(least, analysis->distances_to_mean.squaredNorm(), 1e-6 * least);
  Random random(1);
  int better = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Eigen::Matrix3Xd other = analysis->consensus;
    for (double& value : other.reshaped()) {
      value += 0.5 * random.Normal();
    }
    better += cost(other) < least ? 1 : 0;
  }
  EXPECT_EQ(better, 0);
}

TEST(Procrustes, UsesTheCommonLandmarksOnly) {
  std::vector<LandmarkSet> sets = {RandomSet(8, 1), RandomSet(5, 1)};
  sets[1].points = sets[0].points.leftCols(5);
  const auto analysis = AnalyzeProcrustes(sets, {});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_THAT(analysis->names, ::testing::ElementsAre("p0", "p1", "p2", "p3", "p4"));
  EXPECT_EQ(analysis->consensus.cols(), 5);
  EXPECT_LT(analysis->distances(0, 1), 1e-7);
}

TEST(Procrustes, OfOneSetIsThatSet) {
  const auto analysis = AnalyzeProcrustes(std::vector{RandomSet(5, 1)}, {});
  ASSERT_THAT(analysis, IsOk());
  EXPECT_TRUE(analysis->converged);
  EXPECT_EQ(analysis->distances.size(), 1);
  EXPECT_LT(analysis->distances_to_mean(0), 1e-12);
}

TEST(Procrustes, RefusesWhatCannotBeSuperimposed) {
  EXPECT_THAT(AnalyzeProcrustes({}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "the 0 sets have 0 landmarks"));
  EXPECT_THAT(AnalyzeProcrustes(std::vector{RandomSet(5, 1), RandomSet(2, 1)}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 sets have 2 landmarks in common"));
  std::vector<LandmarkSet> sets = {RandomSet(4, 1), RandomSet(4, 1)};
  sets[1].points.colwise() = Eigen::Vector3d(1, 2, 3);
  EXPECT_THAT(AnalyzeProcrustes(sets, {}),
              StatusIs(absl::StatusCode::kFailedPrecondition, "set 1 coincide"));
  ProcrustesOptions options;
  options.max_iterations = 0;
  EXPECT_THAT(AnalyzeProcrustes(sets, options),
              StatusIs(absl::StatusCode::kInvalidArgument, "0 iterations"));
  options = {};
  options.tolerance = std::nan("");
  EXPECT_THAT(AnalyzeProcrustes(sets, options),
              StatusIs(absl::StatusCode::kInvalidArgument, "tolerance"));
}

ProcrustesOptions Fidentis(ProcrustesSize size) {
  ProcrustesOptions options;
  options.size = size;
  options.variant = ProcrustesOptions::Variant::kFidentis;
  return options;
}

TEST(FidentisProcrustes, BringsSetsToSize200WithoutCentring) {
  const std::vector<LandmarkSet> sets = {RandomSet(6, 1)};
  const auto analysis = AnalyzeProcrustes(sets, Fidentis(ProcrustesSize::kNormalized));
  ASSERT_THAT(analysis, IsOk());
  EXPECT_NEAR(CentroidSizeOf(analysis->aligned[0]), 200, 1e-9);
  EXPECT_TRUE(analysis->aligned[0].isApprox(sets[0].points * (200 / CentroidSizeOf(sets[0].points)),
                                            1e-12));
}

TEST(FidentisProcrustes, TakesAMirroredSetForTheSame) {
  std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 1)};
  sets[1].points.row(0) *= -1;
  const auto analysis = AnalyzeProcrustes(sets, Fidentis(ProcrustesSize::kNormalized));
  ASSERT_THAT(analysis, IsOk());
  EXPECT_LT(analysis->distances(0, 1), 1e-9);
}

TEST(FidentisProcrustes, TakesAMovedSetForAnother) {
  std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 1)};
  sets[1].points.colwise() += Eigen::Vector3d(15, 0, 0);
  const auto analysis = AnalyzeProcrustes(sets, Fidentis(ProcrustesSize::kNormalized));
  ASSERT_THAT(analysis, IsOk());
  EXPECT_GT(analysis->distances(0, 1), 0.05);
}

TEST(FidentisProcrustes, StopsByItsThresholdAndMeasuresWithoutAnotherRotation) {
  const std::vector<LandmarkSet> sets = {RandomSet(10, 1), RandomSet(10, 2), RandomSet(10, 3)};
  const auto analysis = AnalyzeProcrustes(sets, Fidentis(ProcrustesSize::kKept));
  ASSERT_THAT(analysis, IsOk());
  EXPECT_NEAR(analysis->distances(0, 2), (analysis->aligned[0] - analysis->aligned[2]).norm(),
              1e-9);
  EXPECT_GE(analysis->iterations, 2);
  ProcrustesOptions loose = Fidentis(ProcrustesSize::kKept);
  loose.fidentis_threshold = 1e6;
  const auto once = AnalyzeProcrustes(sets, loose);
  ASSERT_THAT(once, IsOk());
  EXPECT_EQ(once->iterations, 1);
  EXPECT_TRUE(once->converged);
  // The first set was the mean, so it did not turn.
  EXPECT_TRUE(once->aligned[0].isApprox(sets[0].points, 1e-12));
}

}  // namespace
}  // namespace cohort
