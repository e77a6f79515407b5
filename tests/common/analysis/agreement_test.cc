#include "common/analysis/agreement.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::StatusIs;

/// The first row as given, the others all the same.
MetricMatrix WithFirstRow(const std::vector<double>& row) {
  MetricMatrix matrix;
  const auto count = static_cast<Eigen::Index>(row.size());
  matrix.values.setOnes(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    matrix.labels.emplace_back(1, static_cast<char>('a' + i));
    matrix.values(0, i) = row[static_cast<size_t>(i)];
  }
  return matrix;
}

NeighbourAgreement Compared(const MetricMatrix& reference, const MetricMatrix& other, int k) {
  absl::StatusOr<NeighbourAgreement> agreement = CompareNeighbours(reference, other, k);
  EXPECT_TRUE(agreement.ok()) << agreement.status();
  return *std::move(agreement);
}

TEST(CompareNeighbours, TellsTheFiveCasesOfTriadsApart) {
  const MetricMatrix reference = WithFirstRow({0, 1, 2, 3, 7, 8, 9});
  const auto first_row = [&](const std::vector<double>& row) {
    return Compared(reference, WithFirstRow(row), 3).rows[0];
  };
  EXPECT_TRUE(first_row({0, 1, 2, 3, 9, 9, 9}).same_order);
  const RowAgreement wrong_order = first_row({0, 2, 1, 3, 9, 9, 9});
  EXPECT_EQ(wrong_order.missed, 0);
  EXPECT_FALSE(wrong_order.same_order);
  EXPECT_FALSE(wrong_order.same_nearest);
  EXPECT_TRUE(wrong_order.nearest_kept);
  EXPECT_EQ(first_row({0, 1, 2, 9, 3, 9, 9}).missed, 1);
  EXPECT_EQ(first_row({0, 1, 9, 9, 2, 3, 9}).missed, 2);
  const RowAgreement none = first_row({0, 9, 9, 9, 1, 2, 3});
  EXPECT_EQ(none.missed, 3);
  EXPECT_FALSE(none.nearest_kept);
}

TEST(CompareNeighbours, SumsOverTheMeshes) {
  const NeighbourAgreement ours =
      Compared(WithFirstRow({0, 1, 2, 3, 7}), WithFirstRow({0, 1, 2, 9, 3}), 3);
  EXPECT_EQ(ours.rows.size(), 5U);
  EXPECT_EQ(ours.correct, 4);
  EXPECT_EQ(ours.wrong_order, 0);
  EXPECT_THAT(ours.missed, ElementsAre(1, 0, 0));
  EXPECT_EQ(ours.kept, 14);
  EXPECT_EQ(ours.wanted, 15);
  EXPECT_EQ(ours.same_nearest, 5);
  EXPECT_EQ(ours.nearest_kept, 5);
}

TEST(CompareNeighbours, BreaksTiesAsNearestNeighboursDoes) {
  // b and c are equally far in the other: b comes first.
  const NeighbourAgreement ours =
      Compared(WithFirstRow({0, 1, 2, 3}), WithFirstRow({0, 1, 1, 3}), 2);
  EXPECT_TRUE(ours.rows[0].same_order);
  const NeighbourAgreement turned =
      Compared(WithFirstRow({0, 2, 1, 3}), WithFirstRow({0, 1, 1, 3}), 2);
  EXPECT_FALSE(turned.rows[0].same_order);
}

TEST(CompareNeighbours, RefusesAKThatCannotBe) {
  const MetricMatrix matrix = WithFirstRow({0, 1, 2});
  EXPECT_THAT(CompareNeighbours(matrix, matrix, 0),
              StatusIs(absl::StatusCode::kInvalidArgument, "0 neighbours of 3 meshes"));
  EXPECT_THAT(CompareNeighbours(matrix, matrix, -1),
              StatusIs(absl::StatusCode::kInvalidArgument, "-1 neighbours"));
  EXPECT_THAT(CompareNeighbours(matrix, matrix, 3),
              StatusIs(absl::StatusCode::kInvalidArgument, "3 neighbours of 3 meshes"));
  EXPECT_THAT(CompareNeighbours(matrix, WithFirstRow({0, 1, 2, 3}), 2),
              StatusIs(absl::StatusCode::kInvalidArgument, "3 and 4 meshes"));
}

TEST(CompareCloseness, CountsCellsWithTheDiagonal) {
  const MetricMatrix reference = WithFirstRow({0, 10, 20});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto ours =
      CompareCloseness(WithFirstRow({0, 11, nan}), WithFirstRow({0, 8, 20}), reference);
  ASSERT_TRUE(ours.ok());
  EXPECT_EQ(ours->first, 1);
  EXPECT_EQ(ours->second, 0);
  EXPECT_EQ(ours->missing, 1);
  EXPECT_EQ(ours->equal, 7);
  EXPECT_EQ(ours->cells[1], Closer::kFirst);
  EXPECT_EQ(ours->cells[2], Closer::kMissing);
}

}  // namespace
}  // namespace cohort
