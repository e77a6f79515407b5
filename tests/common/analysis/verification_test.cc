#include "common/analysis/verification.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using testing::StatusIs;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

VerificationScores Scores(std::vector<double> genuine, std::vector<double> impostor) {
  std::sort(genuine.begin(), genuine.end());
  std::sort(impostor.begin(), impostor.end());
  return {.genuine = std::move(genuine), .impostor = std::move(impostor)};
}

Verification Verified(const VerificationScores& scores) {
  absl::StatusOr<Verification> verification = VerifyPairs(scores);
  EXPECT_TRUE(verification.ok()) << verification.status();
  return *std::move(verification);
}

TEST(VerifyPairs, AgreesWithSciPy) {
  const ReferenceValues scipy("scipy.txt");
  const absl::StatusOr<VerificationScores> scores = CollectScores(
      ReferenceMatrix("a"), {.persons = ReferenceLabels(1), .sessions = {}}, Gallery::kAllOthers);
  ASSERT_TRUE(scores.ok()) << scores.status();
  EXPECT_EQ(scores->genuine.size() + scores->impostor.size(), 120U);
  const Verification ours = Verified(*scores);
  EXPECT_NEAR(ours.equal_error_rate, scipy["equal_error_rate"][0], 1e-12);
  EXPECT_NEAR(ours.d_prime, scipy["d_prime"][0], 1e-12);
  EXPECT_NEAR(ours.area, scipy["area"][0], 1e-12);
}

TEST(VerifyPairs, HasNoErrorWhereTheClassesAreApart) {
  const Verification ours = Verified(Scores({1, 2}, {3, 4, 5}));
  EXPECT_EQ(ours.equal_error_rate, 0);
  EXPECT_EQ(ours.area, 1);
  EXPECT_EQ(ours.nearest_equal.threshold, 2);
  ASSERT_EQ(ours.roc.size(), 3U) << "the ends and the corner";
  EXPECT_EQ(ours.roc[0].threshold, -kInfinity);
  EXPECT_EQ(ours.roc[1].threshold, 2);
  EXPECT_EQ(ours.roc[2].threshold, 5);
  EXPECT_EQ(ours.roc[2].false_accept_rate, 1);
  EXPECT_EQ(ours.roc[2].false_reject_rate, 0);
}

TEST(VerifyPairs, IsAtTheMiddleWhereTheClassesAreTheSame) {
  const Verification ours = Verified(Scores({1, 2, 3, 4}, {1, 2, 3, 4}));
  EXPECT_DOUBLE_EQ(ours.equal_error_rate, 0.5);
  EXPECT_DOUBLE_EQ(ours.area, 0.5);
  EXPECT_EQ(ours.d_prime, 0);
  EXPECT_EQ(ours.nearest_equal.threshold, 2);
}

TEST(VerifyPairs, CountsByHand) {
  // Genuine 1 2 6, impostor 3 4 5 7: at 3 FAR is 1/4 and FRR 1/3, at 4 FAR is 2/4.
  const Verification ours = Verified(Scores({6, 1, 2}, {7, 3, 5, 4}));
  EXPECT_DOUBLE_EQ(ours.equal_error_rate, 1.0 / 3) << "on the way from 3 to 4";
  EXPECT_EQ(ours.nearest_equal.threshold, 3);
  EXPECT_DOUBLE_EQ(ours.area, 9.0 / 12);
  // Means 3 and 4.75, variances (4 + 1 + 9) / 3 and 2.1875.
  EXPECT_DOUBLE_EQ(ours.d_prime, 1.75 / std::sqrt(0.5 * (14.0 / 3 + 2.1875)));
  const ErrorRates rates = RatesAt(Scores({6, 1, 2}, {7, 3, 5, 4}), 3.5);
  EXPECT_THAT(rates.false_accept_rate, DoubleEq(0.25));
  EXPECT_THAT(rates.false_reject_rate, DoubleEq(1.0 / 3));
}

TEST(VerifyPairs, KeepsCornersThatAreRatesAtTheirThreshold) {
  Random random(3);
  std::vector<double> genuine;
  std::vector<double> impostor;
  for (int i = 0; i < 300; ++i) {
    genuine.push_back(std::floor(random.Uniform(0, 60)));  // With ties, also between classes.
    impostor.push_back(std::floor(random.Uniform(20, 100)));
  }
  const VerificationScores scores = Scores(genuine, impostor);
  const Verification ours = Verified(scores);
  for (const ErrorRates& point : ours.roc) {
    const ErrorRates expected = RatesAt(scores, point.threshold);
    EXPECT_EQ(point.false_accept_rate, expected.false_accept_rate);
    EXPECT_EQ(point.false_reject_rate, expected.false_reject_rate);
  }
  double wins = 0;
  for (const double g : genuine) {
    for (const double i : impostor) {
      wins += g < i ? 1 : g == i ? 0.5 : 0;
    }
  }
  EXPECT_NEAR(ours.area, wins / (300 * 300), 1e-12);
}

TEST(VerifyPairs, RefusesOneClassAlone) {
  EXPECT_THAT(VerifyPairs(Scores({}, {1})),
              StatusIs(absl::StatusCode::kFailedPrecondition, "there are 0 and 1"));
}

TEST(RatesAtFalseAccepts, FindsTheLargestThresholdThatKeepsThem) {
  const VerificationScores scores = Scores({1, 2, 6}, {3, 4, 5, 7});
  EXPECT_EQ(RatesAtFalseAccepts(scores, 0.25).threshold, 3);
  EXPECT_EQ(RatesAtFalseAccepts(scores, 0.74).threshold, 4);
  EXPECT_EQ(RatesAtFalseAccepts(scores, 0.75).threshold, 6) << "6 accepts no more impostors";
  EXPECT_EQ(RatesAtFalseAccepts(scores, 0).threshold, 2);
  EXPECT_EQ(RatesAtFalseAccepts(Scores({5}, {1, 2}), 0.1).threshold, -kInfinity);
}

TEST(CollectScores, TellsThePairsApart) {
  MetricMatrix matrix = RandomDistances(5, 2, 1);
  matrix.values(0, 2) = matrix.values(2, 0) = std::numeric_limits<double>::quiet_NaN();
  const Identities identities = {.persons = {"p", "p", "q", "q", ""},
                                 .sessions = {"1", "2", "1", "1", "2"}};
  const auto all = CollectScores(matrix, identities, Gallery::kAllOthers);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->genuine.size(), 2U);
  EXPECT_EQ(all->impostor.size(), 3U);
  EXPECT_EQ(all->missing, 1);
  EXPECT_EQ(all->unknown, 4);
  const auto other_sessions = CollectScores(matrix, identities, Gallery::kOtherSessions);
  ASSERT_TRUE(other_sessions.ok());
  EXPECT_THAT(other_sessions->genuine, ElementsAre(matrix.values(1, 0)));
  EXPECT_EQ(other_sessions->impostor.size(), 2U);
  EXPECT_EQ(other_sessions->same_session, 3);
}

TEST(HistogramOf, CountsEachValueOnce) {
  const ScoreHistogram histogram = HistogramOf(Scores({0, 1}, {1, 2, 4}), 4);
  EXPECT_EQ(histogram.first, 0);
  EXPECT_EQ(histogram.width, 1);
  EXPECT_THAT(histogram.genuine, ElementsAre(1, 1, 0, 0));
  EXPECT_THAT(histogram.impostor, ElementsAre(0, 1, 1, 1));
  EXPECT_THAT(HistogramOf(Scores({2}, {2}), 4).genuine, ElementsAre(1));
  EXPECT_THAT(HistogramOf({}, 4).genuine, ElementsAre(0));
}

}  // namespace
}  // namespace cohort
