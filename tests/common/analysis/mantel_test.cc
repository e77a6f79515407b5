#include "common/analysis/mantel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/thread_pool.h"
#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::StatusIs;

constexpr double kTolerance = 1e-12;

MantelResult Tested(const MetricMatrix& a, const MetricMatrix& b, const MantelOptions& options) {
  SerialExecutor executor;
  const absl::StatusOr<MantelResult> result = MantelTest(a, b, options, executor);
  EXPECT_TRUE(result.ok()) << result.status();
  return *result;
}

/// Three standard errors of a share found by `permutations` draws, and by vegan's 99,999.
double ThreeErrors(double p, int64_t permutations) {
  return 3 * std::sqrt(p * (1 - p) * (1 / static_cast<double>(permutations) + 1e-5));
}

void ExpectAsVegan(const std::string& name, Correlation correlation) {
  const ReferenceValues r("r.txt");
  const MantelOptions options{.correlation = correlation, .permutations = 19999};
  const MantelResult two = Tested(ReferenceMatrix("a"), ReferenceMatrix("b"), options);
  EXPECT_NEAR(two.r, r["mantel_" + name][0], kTolerance);
  EXPECT_NEAR(two.p, r["mantel_" + name][1], ThreeErrors(two.p, options.permutations));
  SerialExecutor executor;
  const absl::StatusOr<MantelResult> three = PartialMantelTest(
      ReferenceMatrix("a"), ReferenceMatrix("b"), ReferenceMatrix("c"), options, executor);
  ASSERT_TRUE(three.ok()) << three.status();
  EXPECT_NEAR(three->r, r["partial_" + name][0], kTolerance);
  EXPECT_NEAR(three->p, r["partial_" + name][1], ThreeErrors(three->p, options.permutations));
}

TEST(MantelTest, AgreesWithVegan) {
  ExpectAsVegan("pearson", Correlation::kPearson);
}

TEST(MantelTest, AgreesWithVeganOnRanks) {
  ExpectAsVegan("spearman", Correlation::kSpearman);
}

TEST(MantelTest, ComesNearTheShareOfAllOrders) {
  const MetricMatrix a = RandomDistances(6, 2, 1);
  MetricMatrix b = RandomDistances(6, 2, 2);
  b.values += 0.4 * a.values;
  const MantelOptions options{.permutations = 50000};
  const MantelResult ours = Tested(a, b, options);
  std::vector<int> order(6);
  std::iota(order.begin(), order.end(), 0);
  int extreme = 0;
  int all = 0;
  do {
    const RowMajorMatrix permuted = a.values(order, order);
    const absl::StatusOr<double> r = MatrixCorrelation(permuted, b.values);
    ASSERT_TRUE(r.ok());
    extreme += *r >= ours.r - 1e-8 ? 1 : 0;
    ++all;
  } while (std::next_permutation(order.begin(), order.end()));
  ASSERT_EQ(all, 720);
  const double exact = extreme / 720.0;
  EXPECT_NEAR(ours.p, exact, 3 * std::sqrt(exact * (1 - exact) / 50000) + 1.0 / 50001);
}

TEST(MantelTest, HasTheStatisticOfTheOffDiagonalCorrelation) {
  const MetricMatrix a = RandomDistances(40, 3, 1);
  const MetricMatrix b = RandomDistances(40, 3, 2);
  EXPECT_NEAR(Tested(a, b, {.permutations = 1}).r, *MatrixCorrelation(a.values, b.values),
              kTolerance);
}

TEST(MantelTest, FindsTheLeastPOfAMatrixWithItself) {
  const MetricMatrix a = RandomDistances(20, 3, 1);
  const MantelResult ours = Tested(a, a, {.permutations = 999});
  EXPECT_NEAR(ours.r, 1, kTolerance);
  EXPECT_EQ(ours.as_extreme, 0);
  EXPECT_EQ(ours.p, 0.001);
}

TEST(MantelTest, TakesBothSidesWhenAsked) {
  const MetricMatrix a = RandomDistances(12, 3, 1);
  MetricMatrix b = a;
  b.values = 10 - a.values.array();
  const MantelResult greater = Tested(a, b, {.permutations = 499});
  const MantelResult two_sided =
      Tested(a, b, {.alternative = Alternative::kTwoSided, .permutations = 499});
  EXPECT_NEAR(greater.r, -1, kTolerance);
  EXPECT_EQ(greater.p, 1);
  EXPECT_EQ(two_sided.p, 1 / 500.0);
}

TEST(MantelTest, IsTheSameForAnyNumberOfThreads) {
  const MetricMatrix a = RandomDistances(15, 3, 1);
  const MetricMatrix b = RandomDistances(15, 3, 8);
  const MantelOptions options{.permutations = 999, .seed = 42};
  ThreadPool threads(3);
  const absl::StatusOr<MantelResult> on_threads = MantelTest(a, b, options, threads);
  ASSERT_TRUE(on_threads.ok());
  EXPECT_EQ(on_threads->as_extreme, Tested(a, b, options).as_extreme);
  EXPECT_NE(on_threads->as_extreme, Tested(a, b, {.permutations = 999, .seed = 43}).as_extreme);
}

TEST(MantelTest, RefusesWhatCannotBeTested) {
  SerialExecutor executor;
  const MetricMatrix a = RandomDistances(5, 2, 1);
  MetricMatrix constant = a;
  constant.values.setConstant(2);
  EXPECT_THAT(MantelTest(a, constant, {}, executor),
              StatusIs(absl::StatusCode::kFailedPrecondition, "constant: every pair is 2"));
  EXPECT_THAT(MantelTest(a, RandomDistances(6, 2, 1), {}, executor),
              StatusIs(absl::StatusCode::kInvalidArgument, "5 and 6 meshes"));
  EXPECT_THAT(MantelTest(a, a, {.permutations = 0}, executor),
              StatusIs(absl::StatusCode::kInvalidArgument, "permutations: 0"));
  EXPECT_THAT(PartialMantelTest(a, RandomDistances(5, 2, 2), a, {}, executor),
              StatusIs(absl::StatusCode::kFailedPrecondition, "nothing is left"));
}

}  // namespace
}  // namespace cohort
