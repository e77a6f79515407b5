#include "common/analysis/leading_eigenpairs.h"

#include <Eigen/Eigenvalues>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

Eigen::MatrixXd RandomSymmetric(Eigen::Index size, uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd matrix(size, size);
  for (double& entry : matrix.reshaped()) {
    entry = random.Uniform(-1, 1);
  }
  return 0.5 * (matrix + matrix.transpose());
}

void ExpectEigenpairs(const Eigen::MatrixXd& matrix, Eigen::Index count) {
  const absl::StatusOr<LeadingEigenpairs> ours = FindLeadingEigenpairs(matrix, count);
  ASSERT_TRUE(ours.ok()) << ours.status();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> full(matrix);
  const double scale = std::max(1.0, full.eigenvalues().cwiseAbs().maxCoeff());
  EXPECT_LT((ours->values - full.eigenvalues().reverse()).cwiseAbs().maxCoeff(), 1e-12 * scale);
  ASSERT_EQ(ours->vectors.cols(), count);
  const Eigen::MatrixXd moved = matrix * ours->vectors;
  const Eigen::MatrixXd scaled = ours->vectors * ours->values.head(count).asDiagonal();
  EXPECT_LT((moved - scaled).cwiseAbs().maxCoeff(), 1e-12 * scale);
  const Eigen::MatrixXd products = ours->vectors.transpose() * ours->vectors;
  EXPECT_LT((products - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(FindLeadingEigenpairs, SolvesTheEigenvalueEquation) {
  ExpectEigenpairs(RandomSymmetric(1, 1), 1);
  ExpectEigenpairs(RandomSymmetric(2, 1), 2);
  ExpectEigenpairs(RandomSymmetric(3, 1), 2);
  ExpectEigenpairs(RandomSymmetric(40, 1), 40);
  ExpectEigenpairs(RandomSymmetric(200, 2), 10);
}

TEST(FindLeadingEigenpairs, SeparatesEqualEigenvalues) {
  // Of 1 - 1/N, the distances of a regular simplex: N - 1 times 1, once 0.
  const Eigen::MatrixXd simplex =
      Eigen::MatrixXd::Identity(30, 30) - Eigen::MatrixXd::Constant(30, 30, 1.0 / 30);
  ExpectEigenpairs(simplex, 30);
  ExpectEigenpairs(Eigen::MatrixXd::Identity(10, 10), 4);
  ExpectEigenpairs(Eigen::MatrixXd::Zero(5, 5), 3);
}

TEST(FindLeadingEigenpairs, SeparatesEigenvaluesThatNearlyMeet) {
  // Wilkinson's matrix: its largest eigenvalues agree to 15 digits.
  Eigen::MatrixXd wilkinson = Eigen::MatrixXd::Zero(21, 21);
  for (Eigen::Index i = 0; i < 21; ++i) {
    wilkinson(i, i) = static_cast<double>(std::abs(i - 10));
    if (i > 0) {
      wilkinson(i, i - 1) = wilkinson(i - 1, i) = 1;
    }
  }
  ExpectEigenpairs(wilkinson, 6);
}

TEST(FindLeadingEigenpairs, FindsTheFewAxesOfManyPoints) {
  Random random(4);
  Eigen::MatrixXd points(80, 3);
  for (double& entry : points.reshaped()) {
    entry = random.Uniform(-5, 5);
  }
  ExpectEigenpairs(points * points.transpose(), 8);
}

}  // namespace
}  // namespace cohort
