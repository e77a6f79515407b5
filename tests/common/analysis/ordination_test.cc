#include "common/analysis/ordination.h"

#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::StatusIs;

Ordination Ordinated(const MetricMatrix& matrix, int axes) {
  absl::StatusOr<Ordination> ordination = OrdinateMeshes(matrix, axes);
  EXPECT_TRUE(ordination.ok()) << ordination.status();
  return *std::move(ordination);
}

TEST(OrdinateMeshes, AgreesWithCmdscale) {
  const ReferenceValues r("r.txt");
  const Ordination ours = Ordinated(ReferenceMatrix("a"), 4);
  ASSERT_EQ(ours.eigenvalues.size(), r["eigenvalues"].size());
  for (size_t i = 0; i < ours.eigenvalues.size(); ++i) {
    EXPECT_NEAR(ours.eigenvalues[i], r["eigenvalues"][i], 1e-10);
  }
  for (Eigen::Index axis = 0; axis < 4; ++axis) {
    std::string name = "axis_";
    name += std::to_string(axis + 1);
    const std::vector<double>& expected = r[name];
    // R's signs are those of its LAPACK.
    const double sign = expected[0] * ours.coordinates(0, axis) < 0 ? -1 : 1;
    for (Eigen::Index i = 0; i < ours.coordinates.rows(); ++i) {
      EXPECT_NEAR(ours.coordinates(i, axis), sign * expected[static_cast<size_t>(i)], 1e-9);
    }
  }
  // GOF: of the sum of |eigenvalues|, and of the positive ones.
  const double explained = std::accumulate(ours.explained.begin(), ours.explained.end(), 0.0);
  EXPECT_NEAR(explained, r["goodness"][1], 1e-10);
  EXPECT_NEAR(explained * (1 - ours.negative_share), r["goodness"][0], 1e-10);
}

TEST(OrdinateMeshes, ReturnsEuclideanDistancesAsTheyWere) {
  const MetricMatrix matrix = RandomDistances(30, 3, 5);
  const Ordination ours = Ordinated(matrix, 10);
  ASSERT_EQ(ours.coordinates.cols(), 3) << "three dimensions are all there are";
  EXPECT_EQ(ours.negative, 0);
  EXPECT_EQ(ours.negative_share, 0);
  EXPECT_NEAR(ours.explained[0] + ours.explained[1] + ours.explained[2], 1, 1e-12);
  for (Eigen::Index i = 0; i < 30; ++i) {
    for (Eigen::Index j = 0; j < 30; ++j) {
      EXPECT_NEAR((ours.coordinates.row(i) - ours.coordinates.row(j)).norm(), matrix.values(i, j),
                  1e-10);
    }
  }
}

TEST(OrdinateMeshes, ReportsNegativeEigenvalues) {
  // The way from a to c over b is shorter than the direct one.
  MetricMatrix matrix;
  matrix.labels = {"a", "b", "c"};
  matrix.values.resize(3, 3);
  matrix.values << 0, 1, 4, 1, 0, 1, 4, 1, 0;
  const Ordination ours = Ordinated(matrix, 2);
  EXPECT_EQ(ours.negative, 1);
  EXPECT_EQ(ours.coordinates.cols(), 1);
  // B has the eigenvalues 8 (along a - c) and -2 (of b against both): trace 6 = 18 / 3.
  EXPECT_NEAR(ours.eigenvalues.front(), 8, 1e-12);
  EXPECT_NEAR(ours.eigenvalues.back(), -2, 1e-12);
  EXPECT_NEAR(ours.negative_share, 0.2, 1e-12);
}

TEST(OrdinateMeshes, TurnsEachAxisToItsLargestCoordinate) {
  const Ordination ours = Ordinated(RandomDistances(25, 6, 3), 5);
  for (Eigen::Index axis = 0; axis < 5; ++axis) {
    EXPECT_GT(ours.coordinates.col(axis).maxCoeff(), -ours.coordinates.col(axis).minCoeff());
  }
}

TEST(OrdinateMeshes, HasNoAxisWhenAllMeshesCoincide) {
  MetricMatrix matrix = RandomDistances(4, 2, 1);
  matrix.values.setZero();
  const Ordination ours = Ordinated(matrix, 2);
  EXPECT_EQ(ours.coordinates.cols(), 0);
  EXPECT_EQ(ours.coordinates.rows(), 4);
}

TEST(OrdinateMeshes, RefusesNoAxesAndTwoMeshes) {
  EXPECT_THAT(OrdinateMeshes(RandomDistances(4, 2, 1), 0),
              StatusIs(absl::StatusCode::kInvalidArgument, "0 axes"));
  EXPECT_THAT(OrdinateMeshes(RandomDistances(2, 2, 1), 1),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 meshes, at least 3"));
}

}  // namespace
}  // namespace cohort
