#include "common/analysis/identification.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::StatusIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Two meshes of p, two of q, one of r.
MetricMatrix Five() {
  MetricMatrix matrix;
  matrix.labels = {"p1", "p2", "q1", "q2", "r1"};
  matrix.values.resize(5, 5);
  matrix.values << 0, 1, 4, 5, 6,  //
      1, 0, 2, 3, 9,               //
      4, 2, 0, 3, 8,               //
      5, 3, 3, 0, 7,               //
      6, 9, 8, 7, 0;
  return matrix;
}

Identities Persons() {
  return {.persons = {"p", "p", "q", "q", "r"}, .sessions = {}};
}

Identification Identified(const MetricMatrix& matrix,
                          const Identities& identities,
                          Gallery gallery = Gallery::kAllOthers) {
  absl::StatusOr<Identification> result = IdentifyPersons(matrix, identities, gallery);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

std::vector<int64_t> Ranks(const Identification& identification) {
  std::vector<int64_t> ranks;
  for (const ProbeSearch& search : identification.searches) {
    ranks.push_back(search.rank);
  }
  return ranks;
}

TEST(IdentifyPersons, RanksTheNearestMeshOfTheSamePerson) {
  const Identification ours = Identified(Five(), Persons());
  // q1: p2 (2) is nearer than q2 (3). q2: p2 is as near as q1, which counts against the match.
  EXPECT_THAT(Ranks(ours), ElementsAre(1, 1, 2, 2, 0));
  EXPECT_EQ(ours.with_mate, 4);
  EXPECT_THAT(ours.match_share, ElementsAre(0.5, 1, 1, 1));
  EXPECT_EQ(ours.ShareAtRank(1), 0.5);
  EXPECT_EQ(ours.ShareAtRank(100), 1);
  EXPECT_EQ(ours.searches[2].mate, 3);
  EXPECT_EQ(ours.searches[2].mate_value, 3);
  EXPECT_EQ(ours.searches[2].impostor, 1);
  EXPECT_EQ(ours.searches[2].impostor_value, 2);
  EXPECT_EQ(ours.searches[4].mate, -1);
  EXPECT_TRUE(std::isnan(ours.searches[4].mate_value));
}

TEST(IdentifyPersons, AgreesWithTheDefinitionInNumPy) {
  const std::vector<double>& expected = ReferenceValues("scipy.txt")["match_share"];
  const Identification ours =
      Identified(ReferenceMatrix("a"), {.persons = ReferenceLabels(1), .sessions = {}});
  EXPECT_EQ(ours.with_mate, 16);
  for (size_t k = 1; k <= expected.size(); ++k) {
    EXPECT_NEAR(ours.ShareAtRank(static_cast<int64_t>(k)), expected[k - 1], 1e-15) << k;
  }
}

TEST(IdentifyPersons, LeavesOutMeshesOfUnknownPerson) {
  Identities identities = Persons();
  identities.persons[1] = "";
  const Identification ours = Identified(Five(), identities);
  ASSERT_EQ(ours.searches.size(), 4U);
  EXPECT_THAT(Ranks(ours), ElementsAre(0, 1, 1, 0)) << "p1 has no mate left, q1 no p2 before it";
}

TEST(IdentifyPersons, NeverFindsAMissingValue) {
  MetricMatrix matrix = Five();
  matrix.values(0, 1) = matrix.values(1, 0) = kNaN;
  matrix.values(1, 2) = matrix.values(2, 1) = kNaN;
  const Identification ours = Identified(matrix, Persons());
  EXPECT_THAT(Ranks(ours), ElementsAre(0, 0, 1, 2, 0));
  EXPECT_EQ(ours.with_mate, 2);
}

TEST(IdentifyPersons, LeavesEachSessionOut) {
  Identities identities = Persons();
  identities.sessions = {"spring", "spring", "spring", "autumn", "autumn"};
  const Identification ours = Identified(Five(), identities, Gallery::kOtherSessions);
  // p1 and p2 are of one session: no mate. q1 has q2 (3) and r1; q2 has q1 and p2, both 3.
  EXPECT_THAT(Ranks(ours), ElementsAre(0, 0, 1, 2, 0));
}

TEST(IdentifyPersons, HasNoSharesWithoutMates) {
  const Identities identities = {.persons = {"a", "b", "c", "d", "e"}, .sessions = {}};
  const Identification ours = Identified(Five(), identities);
  EXPECT_EQ(ours.with_mate, 0);
  EXPECT_TRUE(ours.match_share.empty());
}

TEST(IdentifyPersons, RefusesLabelsThatSayNothing) {
  const auto identify = [](const Identities& identities, Gallery gallery) {
    return IdentifyPersons(Five(), identities, gallery).status();
  };
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(identify({.persons = {"p", "", "p", "p", "p"}, .sessions = {}}, Gallery::kAllOthers),
              StatusIs(kInvalid, "all meshes have the same person, p"));
  EXPECT_THAT(identify({.persons = {"", "", "", "", ""}, .sessions = {}}, Gallery::kAllOthers),
              StatusIs(kInvalid, "no mesh has a person"));
  EXPECT_THAT(identify({.persons = {"p"}, .sessions = {}}, Gallery::kAllOthers),
              StatusIs(kInvalid, "1 labels of person for 5 meshes"));
  EXPECT_THAT(identify(Persons(), Gallery::kOtherSessions),
              StatusIs(kInvalid, "0 labels of session"));
}

}  // namespace
}  // namespace cohort
