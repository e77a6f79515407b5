#include "common/analysis/metric_matrix.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

MetricMatrix ThreeMeshes() {
  MetricMatrix matrix;
  matrix.labels = {"a", "b", "c"};
  matrix.values.resize(3, 3);
  matrix.values << 0, 1, 4,  //
      3, 0, kNaN,            //
      2, 5, 0;
  return matrix;
}

RowMajorMatrix RandomMatrix(Eigen::Index n, uint64_t seed) {
  Random random(seed);
  RowMajorMatrix matrix(n, n);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix(i / n, i % n) = random.Uniform(1, 5);
  }
  return matrix;
}

std::vector<int64_t> Columns(const std::vector<Neighbour>& neighbours) {
  std::vector<int64_t> columns;
  columns.reserve(neighbours.size());
  for (const Neighbour& neighbour : neighbours) {
    columns.push_back(neighbour.column);
  }
  return columns;
}

TEST(LargeMatrix, KnowsNothingAtFirst) {
  LargeMatrix matrix({"a", "b"});
  EXPECT_TRUE(matrix.View().values.array().isNaN().all());
  matrix.Values()(1, 0) = 3;
  EXPECT_EQ(matrix.View().values(1, 0), 3);
  EXPECT_TRUE(std::isnan(matrix.View().values(0, 1)));
  EXPECT_EQ(matrix.View().labels[1], "b");
}

TEST(LargeMatrix, IsACopyThatCanBeChanged) {
  const MetricMatrix first = ThreeMeshes();
  LargeMatrix copy(first);
  EXPECT_EQ(copy.Labels(), first.labels);
  EXPECT_EQ(copy.View().values(0, 2), 4);
  copy.Values()(0, 2) = 7;
  EXPECT_EQ(first.values(0, 2), 4);
}

TEST(MatrixView, OfNothingIsEmpty) {
  const MatrixView nothing;
  EXPECT_EQ(nothing.values.size(), 0);
  EXPECT_TRUE(nothing.labels.empty());
}

// More than one square of the walk, and one that is cut off.
TEST(Symmetrize, DoesEveryPairOfALargeMatrixOnce) {
  constexpr Eigen::Index kCount = 1100;
  RowMajorMatrix directed = RandomMatrix(kCount, 3);
  directed(1, 1050) = kNaN;
  directed(700, 2) = 0.0;
  directed(2, 700) = -0.0;
  for (const PairRule rule : {PairRule::kMean, PairRule::kMax}) {
    RowMajorMatrix symmetric = directed;
    Symmetrize(rule, symmetric);
    for (Eigen::Index row = 0; row < kCount; ++row) {
      for (Eigen::Index column = 0; column < kCount; ++column) {
        const double there = directed(row, column);
        const double back = directed(column, row);
        const double expected =
            rule == PairRule::kMean ? 0.5 * (there + back) : std::max(there, back);
        if (std::isnan(there) || std::isnan(back)) {
          ASSERT_TRUE(std::isnan(symmetric(row, column))) << row << ", " << column;
        } else {
          ASSERT_EQ(symmetric(row, column), expected) << row << ", " << column;
          ASSERT_EQ(std::signbit(symmetric(row, column)), std::signbit(expected));
        }
      }
    }
  }
}

TEST(Symmetrized, TakesTheMeanOfBothDirections) {
  const MetricMatrix symmetric = Symmetrized(ThreeMeshes(), PairRule::kMean);
  EXPECT_EQ(symmetric.labels, ThreeMeshes().labels);
  EXPECT_EQ(symmetric.values(0, 1), 2);
  EXPECT_EQ(symmetric.values(1, 0), 2);
  EXPECT_EQ(symmetric.values(0, 2), 3);
  EXPECT_EQ(symmetric.values(2, 2), 0);
}

TEST(Symmetrized, TakesTheLargerOfBothDirections) {
  const MetricMatrix symmetric = Symmetrized(ThreeMeshes(), PairRule::kMax);
  EXPECT_EQ(symmetric.values(0, 1), 3);
  EXPECT_EQ(symmetric.values(1, 0), 3);
  EXPECT_EQ(symmetric.values(2, 0), 4);
}

TEST(Symmetrized, LeavesAPairUnmeasuredIfOneDirectionIs) {
  const MetricMatrix mean = Symmetrized(ThreeMeshes(), PairRule::kMean);
  const MetricMatrix max = Symmetrized(ThreeMeshes(), PairRule::kMax);
  EXPECT_TRUE(std::isnan(mean.values(1, 2)) && std::isnan(mean.values(2, 1)));
  EXPECT_TRUE(std::isnan(max.values(1, 2)) && std::isnan(max.values(2, 1)));
}

TEST(NearestNeighbours, AreAscendingWithoutTheDiagonal) {
  const auto neighbours = NearestNeighbours(ThreeMeshes(), 2);
  ASSERT_EQ(neighbours.size(), 3U);
  EXPECT_THAT(Columns(neighbours[0]), ::testing::ElementsAre(1, 2));
  EXPECT_THAT(Columns(neighbours[2]), ::testing::ElementsAre(0, 1));
  EXPECT_EQ(neighbours[2][0].value, 2);
}

TEST(NearestNeighbours, LeaveOutWhatWasNotMeasured) {
  EXPECT_THAT(Columns(NearestNeighbours(ThreeMeshes(), 2)[1]), ::testing::ElementsAre(0));
}

TEST(NearestNeighbours, AreTheGivenNumber) {
  EXPECT_THAT(Columns(NearestNeighbours(ThreeMeshes(), 1)[0]), ::testing::ElementsAre(1));
  EXPECT_TRUE(NearestNeighbours(ThreeMeshes(), 0)[0].empty());
}

TEST(NearestNeighbours, BreakTiesByTheLowerColumn) {
  MetricMatrix matrix;
  matrix.values = RowMajorMatrix::Ones(6, 6);
  EXPECT_THAT(Columns(NearestNeighbours(matrix, 3)[1]), ::testing::ElementsAre(0, 2, 3));
}

TEST(MatrixCorrelation, IsOneForALinearMap) {
  const RowMajorMatrix a = RandomMatrix(20, 1);
  const RowMajorMatrix b = 3 * a.array() + 7;
  const auto correlation = MatrixCorrelation(a, b);
  ASSERT_THAT(correlation, IsOk());
  EXPECT_NEAR(*correlation, 1, 1e-12);
  EXPECT_NEAR(*MatrixCorrelation(a, -b), -1, 1e-12);
}

TEST(MatrixCorrelation, MatchesAHandComputedValue) {
  RowMajorMatrix a(3, 3);
  RowMajorMatrix b(3, 3);
  a << 9, 1, 2, 3, 9, 4, 5, 6, 9;
  b << 0, 2, 1, 4, 0, 3, 6, 5, 0;  // ranks of a with neighbours swapped: r = 1 - 6 * 6 / (6 * 35)
  const auto correlation = MatrixCorrelation(a, b);
  ASSERT_THAT(correlation, IsOk());
  EXPECT_NEAR(*correlation, 1 - 36.0 / 210.0, 1e-12);
}

TEST(MatrixCorrelation, DoesNotSeeTheDiagonal) {
  const RowMajorMatrix a = RandomMatrix(10, 1);
  RowMajorMatrix b = a;
  b.diagonal().setConstant(1e9);
  EXPECT_NEAR(*MatrixCorrelation(a, b), 1, 1e-12);
}

TEST(MatrixCorrelation, RefusesWrongSizes) {
  const RowMajorMatrix four = RandomMatrix(4, 1);
  EXPECT_THAT(MatrixCorrelation(four, RandomMatrix(5, 1)),
              StatusIs(absl::StatusCode::kInvalidArgument, "4 x 4 and 5 x 5"));
  EXPECT_THAT(MatrixCorrelation(RandomMatrix(2, 1), RandomMatrix(2, 1)),
              StatusIs(absl::StatusCode::kInvalidArgument, "N >= 3"));
  EXPECT_THAT(MatrixCorrelation(RowMajorMatrix(4, 3), RowMajorMatrix(4, 3)),
              StatusIs(absl::StatusCode::kInvalidArgument, "4 x 3"));
}

TEST(MatrixCorrelation, RefusesAConstantMatrix) {
  EXPECT_THAT(MatrixCorrelation(RandomMatrix(4, 1), RowMajorMatrix::Constant(4, 4, 0.1)),
              StatusIs(absl::StatusCode::kFailedPrecondition, "0.1"));
}

TEST(MatrixCorrelation, RefusesUnmeasuredEntries) {
  RowMajorMatrix a = RandomMatrix(4, 1);
  a(1, 2) = kNaN;
  EXPECT_THAT(MatrixCorrelation(a, RandomMatrix(4, 2)),
              StatusIs(absl::StatusCode::kFailedPrecondition, "not measured"));
}

}  // namespace
}  // namespace cohort
