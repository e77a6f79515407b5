#include "common/geometry/comparison/fidentis_metrics.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/geometry/comparison/metrics.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsNan;
using testing::IsOk;
using testing::StatusIs;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

float Of(std::span<const float> values, Metric metric) {
  return ComputeFidentisMetrics(values).at(static_cast<size_t>(metric));
}

/// 1, 2, ..., n.
std::vector<float> Numbers(int n) {
  std::vector<float> numbers(static_cast<size_t>(n));
  std::iota(numbers.begin(), numbers.end(), 1.0F);
  return numbers;
}

TEST(FidentisMetrics, AreThoseOfTheirFormulas) {
  const std::vector<float> values = {1, 8, 2, 4};
  EXPECT_FLOAT_EQ(Of(values, Metric::kRms), std::sqrt(85.0F / 4));
  EXPECT_EQ(Of(values, Metric::kMean), 3.75F);
  EXPECT_FLOAT_EQ(Of(values, Metric::kGeometricMean), std::pow(64.0F, 0.25F));
  EXPECT_EQ(Of(values, Metric::kMin), 1);
  EXPECT_EQ(Of(values, Metric::kMax), 8);
  EXPECT_FLOAT_EQ(Of(values, Metric::kVariance), 85.0F / 4 - 3.75F * 3.75F);
  EXPECT_EQ(Of(values, Metric::kPercentile75), 4);
}

TEST(FidentisMetrics, AreCloseToOursInDouble) {
  Random random(7);
  std::vector<float> values;
  std::vector<double> exact;
  for (int i = 0; i < 2000; ++i) {
    values.push_back(static_cast<float>(random.Uniform(0.01, 9)));
    exact.push_back(double{values.back()});
  }
  for (const Metric metric : {Metric::kRms, Metric::kMean, Metric::kGeometricMean, Metric::kMin,
                              Metric::kMax, Metric::kVariance, Metric::kPercentile75}) {
    // 2000 roundings of up to 3e-8 of the sum, mostly cancelling; none of a product of 2000 roots.
    const double expected = MetricsOfDistances(exact).at(static_cast<size_t>(metric));
    EXPECT_NEAR(double{Of(values, metric)}, expected, 3e-5 * expected) << MetricName(metric);
  }
}

TEST(FidentisMetrics, AddInFloat32InOrder) {
  EXPECT_EQ(Of(std::vector<float>{16777216, 1, 1, 1}, Metric::kMean), 4194304);
  EXPECT_EQ(Of(std::vector<float>{1, 1, 1, 1, 16777216}, Metric::kMean), 16777220 / 5.0F);
}

TEST(FidentisMetrics, GeometricMeanIsZeroWithAZeroAndNanWithANegative) {
  EXPECT_EQ(Of(std::vector<float>{2, 0, 5}, Metric::kGeometricMean), 0);
  EXPECT_THAT(Of(std::vector<float>{2, -1, 5}, Metric::kGeometricMean), IsNan());
  EXPECT_THAT(Of(std::vector<float>{0, -1}, Metric::kGeometricMean), IsNan());
}

TEST(FidentisMetrics, SignedExtremesAreAlgebraic) {
  const std::vector<float> values = {-7, 2, -1};
  EXPECT_EQ(Of(values, Metric::kMin), -7);
  EXPECT_EQ(Of(values, Metric::kMax), 2);
  EXPECT_EQ(Of(values, Metric::kMean), -2);
  EXPECT_FLOAT_EQ(Of(values, Metric::kRms), std::sqrt(18.0F));
}

TEST(FidentisMetrics, VarianceIsZeroIfTheMeanIs) {
  EXPECT_EQ(Of(std::vector<float>{-1, 1}, Metric::kVariance), 0);
}

TEST(FidentisMetrics, P75IsTheValueAtThreeQuartersLessAHalf) {
  EXPECT_EQ(Of(Numbers(10000), Metric::kPercentile75), 7500);  // 0-based 7499
  EXPECT_EQ(Of(Numbers(1500), Metric::kPercentile75), 1125);   // 1124.5 cut
  EXPECT_EQ(Of(Numbers(4), Metric::kPercentile75), 3);
  EXPECT_EQ(Of(Numbers(3), Metric::kPercentile75), 2);
  EXPECT_EQ(Of(Numbers(1), Metric::kPercentile75), 1);
}

TEST(FidentisMetrics, P75OfSignedValuesIsSortedWithSignsAndGivenWithout) {
  EXPECT_EQ(Of(std::vector<float>{-9, -8, -5, 1}, Metric::kPercentile75), 5);
}

TEST(FidentisMetrics, AreNanWithANanAndWithoutValues) {
  EXPECT_THAT(ComputeFidentisMetrics(std::vector<float>{1, kNan, 2}), Each(IsNan()));
  EXPECT_THAT(ComputeFidentisMetrics({}), Each(IsNan()));
}

TEST(FidentisWindow, LeavesTheValuesAsTheyAreWithinZeroAndOne) {
  EXPECT_THAT(FidentisWindow(std::vector<float>{3, -1, 2}, {}), ElementsAre(3, -1, 2));
}

TEST(FidentisWindow, IsASingleZeroIfUpperIsNotAboveLower) {
  EXPECT_THAT(FidentisWindow(Numbers(9), {0.5, 0.5}), ElementsAre(0));
  EXPECT_THAT(FidentisWindow(Numbers(9), {0.7, 0.2}), ElementsAre(0));
}

TEST(FidentisWindow, CutsSortedValuesWithoutItsUpperEnd) {
  const std::vector<float> values = {9, -2, 7, 4, 1, 0, 3, 8, 5, 6};
  // trunc(10 * 0.25 - 0.5) = 2 up to trunc(10 * 0.75 - 0.5) = 7
  EXPECT_THAT(FidentisWindow(values, {0.25, 0.75}), ElementsAre(1, 3, 4, 5, 6));
  EXPECT_THAT(FidentisWindow(values, {0, 0.25}), ElementsAre(-2, 0));
  EXPECT_THAT(FidentisWindow(values, {0.04, 0.05}), IsEmpty());
}

TEST(FidentisWindow, LosesTheLargestValueWithALowerThresholdAlone) {
  EXPECT_THAT(FidentisWindow(Numbers(10), {0.75, 1}), ElementsAre(8, 9));
}

TEST(FidentisWindow, SortsNanLast) {
  EXPECT_THAT(FidentisWindow(std::vector<float>{kNan, 2, kNan, 1}, {0, 0.7}), ElementsAre(1, 2));
}

TEST(FidentisThresholds, MustBeShares) {
  EXPECT_THAT(FidentisThresholds{}.Validate(), IsOk());
  EXPECT_THAT((FidentisThresholds{0, 75}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "0 and 75"));
  EXPECT_THAT((FidentisThresholds{std::nan(""), 1}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "within 0..1"));
}

TEST(FidentisNormals, AreThePlainMeanOfUnitFaceNormals) {
  // A large face in the x-y plane and a small one in the y-z plane share an edge.
  Eigen::Matrix3Xf vertices(3, 4);
  vertices << 0, 100, 0, 0,  //
      0, 0, 1, 0,            //
      0, 0, 0, 0.1F;
  Matrix3Xi faces(3, 2);
  faces << 0, 0,  //
      1, 2,       //
      2, 3;
  const Eigen::Matrix3Xf normals = FidentisNormals(vertices, faces);
  EXPECT_EQ(normals.col(0), Eigen::Vector3f(0.5F, 0, 0.5F));
  EXPECT_EQ(normals.col(1), Eigen::Vector3f(0, 0, 1));
  EXPECT_EQ(normals.col(3), Eigen::Vector3f(1, 0, 0));
}

TEST(FidentisNormals, OfAVertexWithoutAFaceMakeAllMetricsOfTheMeshNan) {
  Eigen::Matrix3Xf vertices(3, 4);
  vertices << 0, 1, 0, 5,  //
      0, 0, 1, 5,          //
      0, 0, 0, 5;
  Matrix3Xi faces(3, 1);
  faces << 0, 1, 2;
  const Eigen::Matrix3Xf normals = FidentisNormals(vertices, faces);
  EXPECT_TRUE(normals.leftCols(3).allFinite());
  EXPECT_TRUE(normals.col(3).array().isNaN().all());
  const auto target = NearestVertex::Build(Eigen::Matrix3Xf::Ones(3, 1));
  const std::vector<float> distances = FidentisSignedDistances(vertices, normals, *target);
  EXPECT_THAT(distances[3], IsNan());
  EXPECT_THAT(ComputeFidentisMetrics(distances), Each(IsNan()));
  EXPECT_THAT(ComputeFidentisMetrics(FidentisAbsolute(distances)), Each(IsNan()));
}

TEST(FidentisSignedDistances, ArePositiveInFrontByTheNormalOfTheComparedVertex) {
  Eigen::Matrix3Xf vertices(3, 4);
  vertices << 0, 0, 3, 0,  //
      0, 0, 0, 0,          //
      2, -4, 0, 0;
  Eigen::Matrix3Xf normals = Eigen::Vector3f(0, 0, 7).replicate(1, 4);
  const auto target = NearestVertex::Build(Eigen::Matrix3Xf::Zero(3, 1));
  // In front, behind, beside (distance 3, but the product is 0) and on a vertex of the target.
  EXPECT_THAT(FidentisSignedDistances(vertices, normals, *target), ElementsAre(2, -4, 0, 0));
  normals *= -1;
  const std::vector<float> distances = FidentisSignedDistances(vertices, normals, *target);
  EXPECT_THAT(distances, ElementsAre(-2, 4, 0, 0));
  EXPECT_THAT(FidentisAbsolute(distances), ElementsAre(2, 4, 0, 0));
}

TEST(FidentisSymmetric, IsTheMeanOfBothDirections) {
  Eigen::MatrixXf matrix(2, 2);
  matrix << 0, 3,  //
      4, 0;
  Eigen::MatrixXf expected(2, 2);
  expected << 0, 3.5F,  //
      3.5F, 0;
  EXPECT_EQ(FidentisSymmetric(matrix), expected);
}

}  // namespace
}  // namespace cohort
