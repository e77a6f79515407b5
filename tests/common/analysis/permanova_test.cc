#include "common/analysis/permanova.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/thread_pool.h"
#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::StatusIs;

using Groups = std::vector<std::string>;

Permanova Tested(const MetricMatrix& matrix,
                 const Groups& groups,
                 const PermanovaOptions& options) {
  SerialExecutor executor;
  const absl::StatusOr<Permanova> table = TestGroups(matrix, groups, options, executor);
  EXPECT_TRUE(table.ok()) << table.status();
  return *table;
}

void ExpectAsAdonis(const std::string& name, size_t column) {
  const ReferenceValues r("r.txt");
  const std::vector<double>& adonis = r["permanova_" + name];
  const Permanova ours =
      Tested(ReferenceMatrix("a"), ReferenceLabels(column), {.permutations = 19999});
  EXPECT_NEAR(ours.sum_of_squares_groups, adonis[0], 1e-10);
  EXPECT_NEAR(ours.sum_of_squares_residual, adonis[1], 1e-10);
  EXPECT_NEAR(ours.sum_of_squares_total, adonis[2], 1e-10);
  EXPECT_NEAR(ours.r_squared, adonis[3], 1e-12);
  EXPECT_NEAR(ours.f, adonis[4], 1e-10);
  // Three standard errors of both shares, and the step of ours: the p of persons is near zero.
  const double error = 3 * std::sqrt(ours.p * (1 - ours.p) * (1 / 19999.0 + 1 / 99999.0));
  EXPECT_NEAR(ours.p, adonis[5], error + 1 / 20000.0);
  EXPECT_EQ(static_cast<double>(ours.groups - 1), adonis[6]);
  EXPECT_EQ(static_cast<double>(ours.meshes - ours.groups), adonis[7]);
}

TEST(TestGroups, AgreesWithAdonisForTwoGroups) {
  ExpectAsAdonis("group", 2);
}

TEST(TestGroups, AgreesWithAdonisForManyGroups) {
  ExpectAsAdonis("person", 1);
}

TEST(TestGroups, IsTheAnovaOfPlacesOnALine) {
  // Places 0, 2 | 6, 8, 10: means 1 and 8, total mean 5.2; squares by hand.
  MetricMatrix matrix;
  const std::vector<double> places = {0, 2, 6, 8, 10};
  matrix.values.resize(5, 5);
  for (size_t i = 0; i < places.size(); ++i) {
    matrix.labels.emplace_back(1, static_cast<char>('a' + i));
    for (size_t j = 0; j < places.size(); ++j) {
      matrix.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          std::abs(places[i] - places[j]);
    }
  }
  const Permanova ours = Tested(matrix, {"x", "x", "y", "y", "y"}, {.permutations = 9999});
  EXPECT_NEAR(ours.sum_of_squares_residual, 2 + 8, 1e-12);
  EXPECT_NEAR(ours.sum_of_squares_groups, 2 * 4.2 * 4.2 + 3 * 2.8 * 2.8, 1e-12);
  EXPECT_NEAR(ours.f, 58.8 / (10.0 / 3), 1e-12);
  // Of the 10 ways to choose the pair, no other leaves as little: 8, 10 leaves 2 + 56 / 3.
  const double exact = 1 / 10.0;
  EXPECT_NEAR(ours.p, exact, 3 * std::sqrt(exact * (1 - exact) / 9999) + 1e-4);
}

TEST(TestGroups, LeavesOutMeshesWithoutAGroup) {
  const MetricMatrix all = RandomDistances(9, 3, 4);
  MetricMatrix some = all;
  some.labels.resize(8);
  some.values = RowMajorMatrix(all.values.topLeftCorner(8, 8));
  const Groups groups = {"x", "y", "x", "y", "x", "y", "x", "y"};
  Groups with_unknown = groups;
  with_unknown.emplace_back();
  const Permanova expected = Tested(some, groups, {.permutations = 99});
  const Permanova ours = Tested(all, with_unknown, {.permutations = 99});
  EXPECT_EQ(ours.f, expected.f);
  EXPECT_EQ(ours.p, expected.p);
  EXPECT_EQ(ours.meshes, 8);
}

TEST(TestGroups, IsTheSameForAnyNumberOfThreads) {
  const MetricMatrix matrix = RandomDistances(12, 3, 4);
  const Groups groups = {"x", "y", "x", "y", "x", "y", "x", "y", "z", "z", "z", "z"};
  ThreadPool threads(3);
  const absl::StatusOr<Permanova> ours =
      TestGroups(matrix, groups, {.permutations = 499, .seed = 3}, threads);
  ASSERT_TRUE(ours.ok());
  EXPECT_EQ(ours->as_extreme, Tested(matrix, groups, {.permutations = 499, .seed = 3}).as_extreme);
}

TEST(TestGroups, RefusesWhatCannotBeTested) {
  SerialExecutor executor;
  const MetricMatrix matrix = RandomDistances(4, 2, 1);
  const auto test = [&](const Groups& groups) {
    return TestGroups(matrix, groups, {}, executor).status();
  };
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(test({"x", "x", "", "x"}), StatusIs(kInvalid, "all meshes are of one group, x"));
  EXPECT_THAT(test({"", "", "", ""}), StatusIs(kInvalid, "no mesh has a group"));
  EXPECT_THAT(test({"a", "b", "c", "d"}), StatusIs(kInvalid, "a group of its own"));
  EXPECT_THAT(test({"a", "b"}), StatusIs(kInvalid, "2 groups for 4 meshes"));
  MetricMatrix missing = matrix;
  missing.values(0, 1) = missing.values(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(TestGroups(missing, Groups{"x", "x", "y", "y"}, {}, executor),
              StatusIs(absl::StatusCode::kFailedPrecondition, "missing"));
}

}  // namespace
}  // namespace cohort
