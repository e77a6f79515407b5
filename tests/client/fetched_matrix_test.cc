#include "client/fetched_matrix.h"

#include <array>
#include <limits>

#include <gmock/gmock.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Mesh 1 of three was rejected.
constexpr std::array<int64_t, 3> kRowOf = {0, -1, 1};

TEST(PutPart, LeavesOutWhatHasNoRow) {
  RowMajorMatrix matrix = RowMajorMatrix::Constant(2, 2, kNaN);
  const std::array<int32_t, 2> rows = {2, 1};
  const std::array<int32_t, 3> columns = {0, 1, 2};
  const std::array<double, 6> values = {20, 21, 22, 10, 11, 12};
  ASSERT_THAT(PutPart({rows, columns, values}, kRowOf, matrix), IsOk());
  EXPECT_EQ(matrix(1, 0), 20);
  EXPECT_EQ(matrix(1, 1), 22);
  EXPECT_TRUE(matrix.row(0).array().isNaN().all());
}

TEST(PutPart, RefusesMeshesThatTheJobDoesNotHave) {
  RowMajorMatrix matrix = RowMajorMatrix::Constant(2, 2, kNaN);
  const std::array<int32_t, 1> known = {0};
  const std::array<double, 1> value = {1};
  for (const int32_t foreign : {3, -1}) {
    const std::array<int32_t, 1> unknown = {foreign};
    EXPECT_THAT(PutPart({unknown, known, value}, kRowOf, matrix),
                StatusIs(absl::StatusCode::kDataLoss, "does not have"));
    EXPECT_THAT(PutPart({known, unknown, value}, kRowOf, matrix),
                StatusIs(absl::StatusCode::kDataLoss, "does not have"));
  }
  EXPECT_TRUE(matrix.array().isNaN().all());
}

}  // namespace
}  // namespace cohort
