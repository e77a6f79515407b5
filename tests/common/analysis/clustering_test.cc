#include "common/analysis/clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/analysis/reference_files.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::StatusIs;

constexpr double kTolerance = 1e-12;

MetricMatrix Line(const std::vector<double>& places) {
  MetricMatrix matrix;
  const auto count = static_cast<Eigen::Index>(places.size());
  matrix.values.resize(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    matrix.labels.push_back(i < 26 ? std::string(1, static_cast<char>('a' + i))
                                   : std::to_string(i));
    for (Eigen::Index j = 0; j < count; ++j) {
      matrix.values(i, j) =
          std::abs(places[static_cast<size_t>(i)] - places[static_cast<size_t>(j)]);
    }
  }
  return matrix;
}

Dendrogram Clustered(const MetricMatrix& matrix, Linkage linkage) {
  const absl::StatusOr<Dendrogram> dendrogram = ClusterMeshes(matrix, linkage);
  EXPECT_TRUE(dendrogram.ok()) << dendrogram.status();
  return *dendrogram;
}

/// Clusters 0.. renamed such that equal partitions are equal vectors.
template <typename Number>
std::vector<int64_t> Renamed(const std::vector<Number>& clusters) {
  std::vector<Number> seen;
  std::vector<int64_t> renamed;
  for (const Number cluster : clusters) {
    const auto found = std::find(seen.begin(), seen.end(), cluster);
    renamed.push_back(found - seen.begin());
    if (found == seen.end()) {
      seen.push_back(cluster);
    }
  }
  return renamed;
}

void ExpectAsSciPy(Linkage linkage) {
  const ReferenceValues scipy("scipy.txt");
  const std::string name(LinkageName(linkage));
  const Dendrogram ours = Clustered(ReferenceMatrix("a"), linkage);
  ASSERT_EQ(ours.merges.size(), scipy[name + "_height"].size());
  for (size_t m = 0; m < ours.merges.size(); ++m) {
    EXPECT_EQ(static_cast<double>(ours.merges[m].left), scipy[name + "_left"][m]) << m;
    EXPECT_EQ(static_cast<double>(ours.merges[m].right), scipy[name + "_right"][m]) << m;
    EXPECT_EQ(static_cast<double>(ours.merges[m].size), scipy[name + "_size"][m]) << m;
    EXPECT_NEAR(ours.merges[m].height, scipy[name + "_height"][m], kTolerance) << m;
  }
  const std::vector<double>& leaves = scipy[name + "_leaves"];
  EXPECT_EQ(ours.leaf_order, std::vector<int64_t>(leaves.begin(), leaves.end()));
  EXPECT_EQ(CutDendrogram(ours, 3), Renamed(scipy[name + "_three_clusters"]));
}

void ExpectAsR(Linkage linkage) {
  const ReferenceValues r("r.txt");
  const std::string name(LinkageName(linkage));
  const Dendrogram ours = Clustered(ReferenceMatrix("a"), linkage);
  const auto count = std::ssize(ours.leaf_order);
  const auto in_r = [&](int64_t c) {
    return static_cast<double>(c < count ? -(c + 1) : c - count + 1);
  };
  ASSERT_EQ(ours.merges.size(), r[name + "_height"].size());
  for (size_t m = 0; m < ours.merges.size(); ++m) {
    EXPECT_EQ(in_r(ours.merges[m].left), r[name + "_merge"][2 * m]) << m;
    EXPECT_EQ(in_r(ours.merges[m].right), r[name + "_merge"][2 * m + 1]) << m;
    EXPECT_NEAR(ours.merges[m].height, r[name + "_height"][m], kTolerance) << m;
  }
  for (size_t place = 0; place < ours.leaf_order.size(); ++place) {
    EXPECT_EQ(static_cast<double>(ours.leaf_order[place] + 1), r[name + "_order"][place]) << place;
  }
}

/// Merges the two nearest of all clusters again and again, from the definition of their distance.
std::vector<double> BruteForceHeights(const RowMajorMatrix& distances, Linkage linkage) {
  std::vector<std::vector<Eigen::Index>> clusters;
  for (Eigen::Index i = 0; i < distances.rows(); ++i) {
    clusters.push_back({i});
  }
  const auto distance = [&](const auto& x, const auto& y) {
    double sum = 0;
    double least = std::numeric_limits<double>::infinity();
    double largest = 0;
    for (const Eigen::Index i : x) {
      for (const Eigen::Index j : y) {
        sum += distances(i, j);
        least = std::min(least, distances(i, j));
        largest = std::max(largest, distances(i, j));
      }
    }
    return linkage == Linkage::kSingle     ? least
           : linkage == Linkage::kComplete ? largest
                                           : sum / static_cast<double>(x.size() * y.size());
  };
  std::vector<double> heights;
  while (clusters.size() > 1) {
    std::tuple<double, size_t, size_t> best(std::numeric_limits<double>::infinity(), 0, 0);
    for (size_t i = 0; i < clusters.size(); ++i) {
      for (size_t j = i + 1; j < clusters.size(); ++j) {
        best = std::min(best, std::tuple(distance(clusters[i], clusters[j]), i, j));
      }
    }
    const auto [height, i, j] = best;
    heights.push_back(height);
    clusters[i].insert(clusters[i].end(), clusters[j].begin(), clusters[j].end());
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(j));
  }
  return heights;
}

void ExpectAsBruteForce(Linkage linkage) {
  for (const uint64_t seed : {1U, 2U, 3U}) {
    const MetricMatrix matrix = RandomDistances(60, 3, seed);
    const std::vector<double> expected = BruteForceHeights(matrix.values, linkage);
    const Dendrogram ours = Clustered(matrix, linkage);
    for (size_t m = 0; m < expected.size(); ++m) {
      ASSERT_NEAR(ours.merges[m].height, expected[m], kTolerance) << "seed " << seed;
    }
  }
}

TEST(ClusterMeshes, MergesAverageLinkageAsSciPyAndR) {
  ExpectAsSciPy(Linkage::kAverage);
  ExpectAsR(Linkage::kAverage);
}

TEST(ClusterMeshes, MergesCompleteLinkageAsSciPyAndR) {
  ExpectAsSciPy(Linkage::kComplete);
  ExpectAsR(Linkage::kComplete);
}

TEST(ClusterMeshes, MergesSingleLinkageAsSciPyAndR) {
  ExpectAsSciPy(Linkage::kSingle);
  ExpectAsR(Linkage::kSingle);
}

TEST(ClusterMeshes, MergesWardsLinkageAsSciPyAndR) {
  ExpectAsSciPy(Linkage::kWard);
  ExpectAsR(Linkage::kWard);
}

TEST(ClusterMeshes, FindsTheHeightsOfBruteForce) {
  ExpectAsBruteForce(Linkage::kAverage);
  ExpectAsBruteForce(Linkage::kComplete);
  ExpectAsBruteForce(Linkage::kSingle);
}

TEST(ClusterMeshes, HasWardsHeightOfTwoPairsInClosedForm) {
  // Pairs 2 apart each, their centres 10 apart: sqrt(2 * 2 * 2 / (2 + 2)) * 10.
  const Dendrogram ours = Clustered(Line({0, 2, 10, 12}), Linkage::kWard);
  EXPECT_NEAR(ours.merges[2].height, std::sqrt(2.0) * 10, kTolerance);
}

TEST(ClusterMeshes, IsTheSameTreeWhenAllAreEquallyFar) {
  MetricMatrix matrix = Line({0, 1, 2, 3});
  matrix.values.setOnes();
  matrix.values.diagonal().setZero();
  const Dendrogram ours = Clustered(matrix, Linkage::kAverage);
  EXPECT_EQ(NewickText(ours, matrix.labels), "(d:0.5,(c:0.5,(a:0.5,b:0.5):0):0);\n");
  EXPECT_EQ(ours.merges.back().size, 4);
}

TEST(ClusterMeshes, OrdersEachMeshOnceAlongTheLeaves) {
  const Dendrogram ours = Clustered(RandomDistances(200, 2, 9), Linkage::kSingle);
  EXPECT_EQ(std::set<int64_t>(ours.leaf_order.begin(), ours.leaf_order.end()).size(), 200U);
  for (size_t m = 1; m < ours.merges.size(); ++m) {
    EXPECT_LE(ours.merges[m - 1].height, ours.merges[m].height);
  }
}

TEST(ClusterMeshes, RefusesWhatIsNoDistanceMatrix) {
  MetricMatrix matrix = Line({0, 1, 5});
  matrix.values(0, 1) = 2;
  EXPECT_THAT(ClusterMeshes(matrix, Linkage::kAverage),
              StatusIs(absl::StatusCode::kInvalidArgument, "b, a is 1, a, b is 2"));
  matrix.values(0, 1) = matrix.values(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ClusterMeshes(matrix, Linkage::kAverage),
              StatusIs(absl::StatusCode::kFailedPrecondition, "a, b is missing"));
}

TEST(NewickText, HalvesTheHeightsAndQuotesWhatNeedsIt) {
  MetricMatrix matrix = Line({0, 2, 10});
  matrix.labels = {"it's a.ply", "b_1.ply", "c"};
  const Dendrogram ours = Clustered(matrix, Linkage::kAverage);
  EXPECT_EQ(NewickText(ours, matrix.labels), "(c:4.5,('it''s a.ply':1,b_1.ply:1):3.5);\n");
}

TEST(NewickText, WritesADeepTree) {
  std::vector<double> places(4000);
  for (size_t i = 0; i < places.size(); ++i) {
    places[i] = static_cast<double>(i) * (1 + 1e-4 * static_cast<double>(i));
  }
  const MetricMatrix matrix = Line(places);
  const Dendrogram ours = Clustered(matrix, Linkage::kSingle);
  const std::vector<std::string> labels(places.size(), "x");
  const std::string text = NewickText(ours, labels);
  EXPECT_EQ(std::count(text.begin(), text.end(), '('), 3999);
  EXPECT_EQ(std::count(text.begin(), text.end(), ')'), 3999);
}

TEST(CutDendrogram, UndoesTheLastMerges) {
  const Dendrogram ours = Clustered(Line({0, 1, 5, 6, 50}), Linkage::kAverage);
  EXPECT_THAT(CutDendrogram(ours, 1), ElementsAre(0, 0, 0, 0, 0));
  EXPECT_THAT(CutDendrogram(ours, 2), ElementsAre(0, 0, 0, 0, 1));
  EXPECT_THAT(CutDendrogram(ours, 3), ElementsAre(0, 0, 1, 1, 2));
  EXPECT_THAT(CutDendrogram(ours, 5), ElementsAre(0, 1, 2, 3, 4));
}

TEST(Linkage, HasANameThatReadsBack) {
  for (const Linkage linkage :
       {Linkage::kAverage, Linkage::kComplete, Linkage::kSingle, Linkage::kWard}) {
    EXPECT_EQ(LinkageFromName(LinkageName(linkage)), linkage);
  }
  EXPECT_EQ(LinkageFromName("upgma"), std::nullopt);
}

}  // namespace
}  // namespace cohort
