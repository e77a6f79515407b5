#include "common/report/histogram.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "common/base/random.h"
#include "common/report/canvas.h"
#include "common/report/pair_distribution.h"
#include "tests/common/report/png_pixels.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::Contains;
using testing::DecodePng;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::IsOk;
using ::testing::Not;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

MetricMatrix FourMeshes() {
  MetricMatrix matrix;
  matrix.labels = {"a", "b", "c", "d"};
  matrix.values.resize(4, 4);
  matrix.values << 0, 1, 2, 3,  //
      10, 0, 4, 5,              //
      20, 40, 0, 6,             //
      30, 50, 60, 0;
  return matrix;
}

PairValues Pairs(const std::vector<double>& same, const std::vector<double>& different) {
  PairValues pairs;
  pairs.by_person = true;
  pairs.same.assign(same.begin(), same.end());
  pairs.different.assign(different.begin(), different.end());
  return pairs;
}

TEST(CollectPairs, CountsEachPairOnceWhenBothDirectionsAreOne) {
  const PairValues pairs = CollectPairs(FourMeshes(), Symmetrization::kMean, {});
  EXPECT_FALSE(pairs.by_person);
  EXPECT_THAT(pairs.different, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(CollectPairs, CountsBothDirectionsOfADirectedMatrix) {
  const PairValues pairs = CollectPairs(FourMeshes(), Symmetrization::kDirected, {});
  EXPECT_THAT(pairs.different, ElementsAre(1, 2, 3, 4, 5, 6, 10, 20, 30, 40, 50, 60));
}

TEST(CollectPairs, SeparatesPersons) {
  const std::vector<std::string> persons = {"x", "x", "y", "y"};
  const PairValues pairs = CollectPairs(FourMeshes(), Symmetrization::kMax, persons);
  EXPECT_TRUE(pairs.by_person);
  EXPECT_THAT(pairs.same, ElementsAre(1, 6));
  EXPECT_THAT(pairs.different, ElementsAre(2, 3, 4, 5));
}

TEST(CollectPairs, LeavesOutUnknownPersonsAndMissingValues) {
  MetricMatrix matrix = FourMeshes();
  matrix.values(0, 1) = kNaN;
  const std::vector<std::string> persons = {"x", "x", "", "x"};
  const PairValues pairs = CollectPairs(matrix, Symmetrization::kMean, persons);
  EXPECT_EQ(pairs.missing, 1);
  EXPECT_EQ(pairs.unknown, 3);
  EXPECT_THAT(pairs.same, ElementsAre(3, 5));
  EXPECT_THAT(pairs.different, IsEmpty());
}

TEST(CollectPairs, IgnoresPersonsWhenNobodyIsKnown) {
  const std::vector<std::string> persons(4);
  const PairValues pairs = CollectPairs(FourMeshes(), Symmetrization::kMean, persons);
  EXPECT_FALSE(pairs.by_person);
  EXPECT_EQ(pairs.different.size(), 6U);
}

TEST(MedianOfSorted, IsTheMiddleOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(MedianOfSorted(std::vector<double>{1, 2, 9}), 2);
  EXPECT_EQ(MedianOfSorted(std::vector<double>{1, 2, 3, 9}), 2.5);
}

TEST(ChooseBins, AreNiceAndHoldEveryValueOnce) {
  std::vector<double> values;
  values.reserve(1000);
  for (int i = 0; i < 1000; ++i) values.push_back(0.37 + i * 0.00201);
  const Bins bins = ChooseBins(Pairs({}, values));
  EXPECT_EQ(bins.width, 0.1);
  EXPECT_NEAR(bins.first, 0.3, 1e-12);
  EXPECT_EQ(bins.beyond, 0);
  // Bin [0.4, 0.5) holds i with 0.03 <= 0.00201 i < 0.13: 15..64.
  const std::vector<int64_t> counts = CountInBins(values, bins);
  EXPECT_EQ(counts[0], 15);
  EXPECT_EQ(counts[1], 50);
  int64_t sum = 0;
  for (const int64_t count : counts) sum += count;
  EXPECT_EQ(sum, 1000);
}

// The quartiles of two lists are found without joining them.
TEST(ChooseBins, OfTwoClassesAreThoseOfAllValuesTogether) {
  Random random(9);
  for (const int of_same : {0, 1, 2, 7, 300, 999, 1000}) {
    std::vector<double> same;
    std::vector<double> different;
    for (int i = 0; i < 1000; ++i) {
      (i < of_same ? same : different).push_back(random.Uniform(0, i < of_same ? 2 : 3));
    }
    std::vector<double> all = same;
    all.insert(all.end(), different.begin(), different.end());
    for (std::vector<double>* values : {&same, &different, &all}) {
      std::sort(values->begin(), values->end());
    }
    const Bins apart = ChooseBins(Pairs(same, different));
    const Bins together = ChooseBins(Pairs({}, all));
    EXPECT_EQ(apart.first, together.first) << of_same;
    EXPECT_EQ(apart.width, together.width) << of_same;
    EXPECT_EQ(apart.count, together.count) << of_same;
    EXPECT_EQ(apart.beyond, together.beyond) << of_same;
  }
}

TEST(ChooseBins, SurroundASingleValue) {
  const Bins bins = ChooseBins(Pairs({}, {1.5}));
  const std::vector<int64_t> counts = CountInBins(std::vector<double>{1.5}, bins);
  EXPECT_THAT(counts, ElementsAre(0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0));
}

TEST(ChooseBins, PutAFailedMeshIntoTheLastBin) {
  std::vector<double> values;
  values.reserve(101);
  for (int i = 0; i < 100; ++i) values.push_back(1 + i * 0.01);
  values.push_back(500);
  const Bins bins = ChooseBins(Pairs({}, values));
  EXPECT_EQ(bins.beyond, 1);
  EXPECT_LT(bins.first + bins.count * bins.width, 10);
  EXPECT_EQ(CountInBins(values, bins).back(), 1);
}

TEST(ChooseBins, DoNotTakeASmallFarClassForAnOutlier) {
  std::vector<double> same;
  same.reserve(100);
  for (int i = 0; i < 100; ++i) same.push_back(1 + i * 0.001);
  const Bins bins = ChooseBins(Pairs(same, {50, 51, 52, 53, 54, 55, 56, 57}));
  EXPECT_EQ(bins.beyond, 0);
}

TEST(HistogramPng, DrawsTwoColoursWithPersonsAndOneWithout) {
  constexpr Rgb kSame = {213, 94, 0};
  constexpr Rgb kDifferent = {0, 114, 178};
  const std::vector<std::string> persons = {"x", "x", "y", "y"};
  const absl::StatusOr<std::string> with = HistogramPng(FourMeshes(), {}, persons);
  ASSERT_THAT(with, IsOk());
  EXPECT_GT(DecodePng(*with).Count(kSame), 100);
  EXPECT_GT(DecodePng(*with).Count(kDifferent), 100);
  const absl::StatusOr<std::string> without = HistogramPng(FourMeshes(), {}, {});
  ASSERT_THAT(without, IsOk());
  EXPECT_EQ(DecodePng(*without).Count(kSame), 0);
  EXPECT_GT(DecodePng(*without).Count(kDifferent), 100);
}

TEST(HistogramPng, DrawsWhenAClassOrEverythingIsEmpty) {
  const std::vector<std::string> all_different = {"1", "2", "3", "4"};
  EXPECT_THAT(HistogramPng(FourMeshes(), {}, all_different), IsOk());
  MetricMatrix matrix = FourMeshes();
  matrix.values.setConstant(kNaN);
  EXPECT_THAT(HistogramPng(matrix, {}, all_different), IsOk());
  matrix.values.setZero();
  EXPECT_THAT(HistogramPng(matrix, {}, {}), IsOk());
  MetricMatrix two;
  two.labels = {"a", "b"};
  two.values.setConstant(2, 2, 0.7);
  EXPECT_THAT(HistogramPng(two, {}, std::vector<std::string>{"x", "x"}), IsOk());
  EXPECT_THAT(HistogramPng({}, {}, {}), IsOk());
}

TEST(HistogramPng, IsTheSameEveryTimeAndHoldsNoTimeStamp) {
  const absl::StatusOr<std::string> first = HistogramPng(FourMeshes(), {}, {});
  const absl::StatusOr<std::string> second = HistogramPng(FourMeshes(), {}, {});
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(*first, *second);
  EXPECT_THAT(testing::PngChunks(*first), Not(Contains("tIME")));
}

TEST(HistogramPng, RefusesSizesThatDisagree) {
  const std::vector<std::string> persons = {"x"};
  EXPECT_THAT(HistogramPng(FourMeshes(), {}, persons),
              StatusIs(absl::StatusCode::kInvalidArgument, "1 persons for 4 x 4"));
}

}  // namespace
}  // namespace cohort
