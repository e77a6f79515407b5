#include "common/analysis/distances.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

void SetPair(MetricMatrix& matrix, Eigen::Index a, Eigen::Index b, double value) {
  matrix.values(a, b) = value;
  matrix.values(b, a) = value;
}

TEST(RequireSymmetric, AllowsTheRoundingOfTextFiles) {
  MetricMatrix matrix = RandomDistances(4, 2, 1);
  matrix.values(0, 1) *= 1 + 1e-12;
  EXPECT_THAT(RequireSymmetric(matrix, 4), IsOk());
  matrix.values(0, 1) *= 1 + 1e-6;
  EXPECT_THAT(RequireSymmetric(matrix, 4), StatusIs(kInvalid, "not symmetric: m1, m0 is "));
}

TEST(RequireSymmetric, TakesAPairHalfMissingForAsymmetric) {
  MetricMatrix matrix = RandomDistances(3, 2, 1);
  matrix.values(0, 1) = kNaN;
  EXPECT_THAT(RequireSymmetric(matrix, 3), StatusIs(kInvalid, "m0, m1 is nan"));
  matrix.values(1, 0) = kNaN;
  EXPECT_THAT(RequireSymmetric(matrix, 3), IsOk());
}

TEST(RequireSymmetric, NamesWhatIsWrongWithTheShape) {
  MetricMatrix matrix = RandomDistances(3, 2, 1);
  EXPECT_THAT(RequireSymmetric(matrix, 4), StatusIs(kInvalid, "3 meshes, at least 4"));
  matrix.labels[2] = "m0";
  EXPECT_THAT(RequireSymmetric(matrix, 3), StatusIs(kInvalid, "mesh m0 is there twice"));
  matrix.labels.pop_back();
  EXPECT_THAT(RequireSymmetric(matrix, 3), StatusIs(kInvalid, "3 rows and 2 labels"));
  matrix.values.resize(2, 3);
  EXPECT_THAT(RequireSymmetric(matrix, 2), StatusIs(kInvalid, "2 rows and 3 columns"));
}

TEST(RequireDissimilarities, RefusesNegativeInfiniteAndSelfDistances) {
  MetricMatrix matrix = RandomDistances(3, 2, 1);
  EXPECT_THAT(RequireDissimilarities(matrix, 3), IsOk());
  SetPair(matrix, 0, 1, -1);
  EXPECT_THAT(RequireDissimilarities(matrix, 3), StatusIs(kInvalid, "m1, m0 is -1"));
  SetPair(matrix, 0, 1, std::numeric_limits<double>::infinity());
  EXPECT_THAT(RequireDissimilarities(matrix, 3), StatusIs(kInvalid, "m1, m0 is inf"));
  SetPair(matrix, 0, 1, 1);
  matrix.values(2, 2) = 1;
  EXPECT_THAT(RequireDissimilarities(matrix, 3), StatusIs(kInvalid, "m2 from itself is 1"));
  matrix.values(2, 2) = kNaN;
  EXPECT_THAT(RequireDissimilarities(matrix, 3), IsOk());
}

TEST(RequireComplete, NamesTheFirstMissingPair) {
  MetricMatrix matrix = RandomDistances(4, 2, 1);
  matrix.values(2, 2) = kNaN;
  EXPECT_THAT(RequireComplete(matrix), IsOk());
  SetPair(matrix, 3, 1, kNaN);
  EXPECT_THAT(RequireComplete(matrix),
              StatusIs(absl::StatusCode::kFailedPrecondition, "m1, m3 is missing"));
}

TEST(CompleteMeshes, TakesAwayAsFewAsTheWorstAllow) {
  MetricMatrix matrix = RandomDistances(5, 2, 1);
  EXPECT_THAT(CompleteMeshes(matrix), ElementsAre(0, 1, 2, 3, 4));
  for (const Eigen::Index other : {0, 2, 3, 4}) {
    SetPair(matrix, 1, other, kNaN);
  }
  EXPECT_THAT(CompleteMeshes(matrix), ElementsAre(0, 2, 3, 4));
  SetPair(matrix, 3, 4, kNaN);
  EXPECT_THAT(CompleteMeshes(matrix), ElementsAre(0, 2, 3)) << "of 3 and 4 the last";
}

TEST(PartOf, KeepsLabelsWithTheirRows) {
  const MetricMatrix matrix = RandomDistances(4, 2, 1);
  const MetricMatrix part = PartOf(matrix, {3, 1});
  EXPECT_THAT(part.labels, ElementsAre("m3", "m1"));
  EXPECT_EQ(part.values(0, 1), matrix.values(3, 1));
}

}  // namespace
}  // namespace cohort
