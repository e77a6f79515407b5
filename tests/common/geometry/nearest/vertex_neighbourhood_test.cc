#include "common/geometry/nearest/vertex_neighbourhood.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;

/// All vertices by (distance, index).
std::vector<NearVertex> Ranked(const Eigen::Matrix3Xd& vertices, const Eigen::Vector3d& query) {
  std::vector<NearVertex> all;
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    const Eigen::Vector3d d = query - vertices.col(v);
    all.push_back({.vertex = static_cast<int32_t>(v),
                   .squared_distance = d.x() * d.x() + (d.y() * d.y() + d.z() * d.z())});
  }
  std::sort(all.begin(), all.end(), [](const NearVertex& a, const NearVertex& b) {
    return std::pair(a.squared_distance, a.vertex) < std::pair(b.squared_distance, b.vertex);
  });
  return all;
}

Eigen::Matrix3Xd RandomPoints(Eigen::Index count) {
  Random random(5);
  Eigen::Matrix3Xd points(3, count);
  for (double& value : points.reshaped()) {
    value = random.Uniform(-50, 50);
  }
  return points;
}

/// Integer places, so that most distances tie; each twice.
Eigen::Matrix3Xd DoubledGrid(int side) {
  Eigen::Matrix3Xd points(3, Eigen::Index{2} * side * side * side);
  Eigen::Index column = 0;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        points.col(column++) << x, y, z;
        points.col(column++) << x, y, z;
      }
    }
  }
  return points;
}

/// Holds both questions against sorting everything.
void ExpectAsBruteForce(const Eigen::Matrix3Xd& vertices, double radius) {
  const auto neighbourhood = VertexNeighbourhood::Build(vertices);
  std::vector<NearVertex> found;
  for (Eigen::Index q = 0; q < vertices.cols(); q += 7) {
    const Eigen::Vector3d query = vertices.col(q) + Eigen::Vector3d::Constant(q % 2 == 0 ? 0 : 0.5);
    std::vector<NearVertex> truth = Ranked(vertices, query);
    for (const int64_t k : {1, 2, 13}) {
      neighbourhood->Nearest(query, k, found);
      const auto kept = std::min<std::ptrdiff_t>(k, std::ssize(truth));
      ASSERT_EQ(found, std::vector<NearVertex>(truth.begin(), truth.begin() + kept))
          << "query " << q << ", k " << k;
    }
    std::erase_if(truth, [radius](const NearVertex& near) {
      return near.squared_distance > radius * radius;
    });
    neighbourhood->Within(query, radius, found);
    ASSERT_EQ(found, truth) << "query " << q;
  }
}

TEST(VertexNeighbourhood, FindsWhatBruteForceFindsAmongRandomPoints) {
  ExpectAsBruteForce(RandomPoints(2000), 9);
}

TEST(VertexNeighbourhood, GivesTiesToTheLowerIndex) {
  ExpectAsBruteForce(DoubledGrid(9), 2);
}

TEST(VertexNeighbourhood, CountsAPointAtExactlyTheRadius) {
  const auto neighbourhood = VertexNeighbourhood::Build(DoubledGrid(3));
  std::vector<NearVertex> found;
  neighbourhood->Within(Eigen::Vector3d::Zero(), 1, found);
  EXPECT_EQ(found.size(), 8U);  // four places, two points each
  neighbourhood->Within(Eigen::Vector3d::Zero(), 0, found);
  EXPECT_EQ(found.size(), 2U);
}

TEST(VertexNeighbourhood, IsExactOnALine) {
  Eigen::Matrix3Xd line = Eigen::Matrix3Xd::Zero(3, 500);
  for (Eigen::Index i = 0; i < line.cols(); ++i) {
    line(1, i) = static_cast<double>(i * 37 % 500);
  }
  ExpectAsBruteForce(line, 3);
}

TEST(VertexNeighbourhood, WorksForOneVertexAndForCoincidingOnes) {
  const auto one = VertexNeighbourhood::Build(Eigen::Vector3d(1, 2, 3));
  std::vector<NearVertex> found;
  one->Nearest({1, 2, 5}, 4, found);
  EXPECT_THAT(found, ElementsAre(NearVertex{.vertex = 0, .squared_distance = 4}));
  one->Within({9, 9, 9}, 1, found);
  EXPECT_TRUE(found.empty());
  ExpectAsBruteForce(Eigen::Vector3d(1, 2, 3).replicate(1, 100), 1);
}

TEST(MeanSpacing, OfAGridIsItsStep) {
  Eigen::Matrix3Xd grid(3, 100);
  for (int x = 0; x < 10; ++x) {
    for (int y = 0; y < 10; ++y) {
      grid.col(10 * x + y) << 2.5 * x, 2.5 * y, 7;
    }
  }
  EXPECT_DOUBLE_EQ(MeanSpacing(*VertexNeighbourhood::Build(grid)), 2.5);
}

TEST(MeanSpacing, CountsDuplicatesAsZero) {
  EXPECT_EQ(MeanSpacing(*VertexNeighbourhood::Build(DoubledGrid(3))), 0);
}

}  // namespace
}  // namespace cohort
