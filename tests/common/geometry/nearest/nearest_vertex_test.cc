#include "common/geometry/nearest/nearest_vertex.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

struct Found {
  std::vector<int32_t> indices;
  std::vector<uint32_t> distance_bits;
  friend bool operator==(const Found&, const Found&) = default;
};

Found Search(const NearestVertex& index, const Eigen::Matrix3Xf& queries) {
  std::vector<int32_t> indices(static_cast<size_t>(queries.cols()), -1);
  std::vector<float> distances(indices.size(), -1);
  index.Find(queries, indices, distances);
  Found found{indices, {}};
  for (const float distance : distances) {
    found.distance_bits.push_back(std::bit_cast<uint32_t>(distance));
  }
  return found;
}

/// The documented formula and tie rule, vertex by vertex.
Found BruteForce(const Eigen::Matrix3Xf& vertices, const Eigen::Matrix3Xf& queries) {
  Found found;
  for (Eigen::Index q = 0; q < queries.cols(); ++q) {
    float best = std::numeric_limits<float>::infinity();
    int32_t best_index = -1;
    for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
      const float dx = queries(0, q) - vertices(0, v);
      const float dy = queries(1, q) - vertices(1, v);
      const float dz = queries(2, q) - vertices(2, v);
      const float distance = std::fma(dx, dx, std::fma(dy, dy, dz * dz));
      if (distance < best) {
        best = distance;
        best_index = static_cast<int32_t>(v);
      }
    }
    found.indices.push_back(best_index);
    found.distance_bits.push_back(std::bit_cast<uint32_t>(best));
  }
  return found;
}

enum class Shape { kRandom, kGrid, kPlane, kLine, kDuplicates, kOnePoint, kClustered, kScales };

float Coordinate(Shape shape, int axis, Random& random) {
  const auto uniform = static_cast<float>(random.Uniform(-100, 100));
  switch (shape) {
    case Shape::kRandom:
      return uniform;
    case Shape::kGrid:  // many ties
      return static_cast<float>(random.Below(7)) - 3;
    case Shape::kPlane:
      return axis == 1 ? 0.1F : uniform;
    case Shape::kLine:
      return axis == 0 ? uniform : -0.3F;
    case Shape::kDuplicates:
      return static_cast<float>(random.Below(2)) * 13.7F;
    case Shape::kOnePoint:
      return 3.3F;
    case Shape::kClustered:
      return static_cast<float>(100 * random.Below(3)) + uniform * 1e-5F;
    case Shape::kScales:  // deep, unbalanced trees
      return uniform * static_cast<float>(std::pow(10.0, random.Uniform(-12, 0)));
  }
  return 0;
}

Eigen::Matrix3Xf Points(Shape shape, Eigen::Index count, uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3Xf points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      points(axis, i) = Coordinate(shape, axis, random);
    }
  }
  return points;
}

class NearestVertexShapes : public ::testing::TestWithParam<std::tuple<Shape, int>> {};

TEST_P(NearestVertexShapes, EqualsBruteForceBitForBit) {
  const auto [shape, count] = GetParam();
  const Eigen::Matrix3Xf vertices = Points(shape, count, 1);
  const std::unique_ptr<const NearestVertex> index = NearestVertex::Build(vertices);

  const Eigen::Matrix3Xf like = Points(shape, 500, 2);
  EXPECT_EQ(Search(*index, like), BruteForce(vertices, like));
  const Eigen::Matrix3Xf random = Points(Shape::kRandom, 500, 3);
  EXPECT_EQ(Search(*index, random), BruteForce(vertices, random));
  const Eigen::Matrix3Xf half_way = Points(Shape::kGrid, 500, 4).array() + 0.5F;  // ties
  EXPECT_EQ(Search(*index, half_way), BruteForce(vertices, half_way));
  EXPECT_EQ(Search(*index, vertices), BruteForce(vertices, vertices));
}

std::string ShapeName(const ::testing::TestParamInfo<std::tuple<Shape, int>>& info) {
  constexpr std::array kNames = {"Random",     "Grid",     "Plane",     "Line",
                                 "Duplicates", "OnePoint", "Clustered", "Scales"};
  return std::string(kNames.at(static_cast<size_t>(std::get<0>(info.param)))) +
         std::to_string(std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(AllShapesAndSizes,
                         NearestVertexShapes,
                         ::testing::Combine(::testing::Values(Shape::kRandom,
                                                              Shape::kGrid,
                                                              Shape::kPlane,
                                                              Shape::kLine,
                                                              Shape::kDuplicates,
                                                              Shape::kOnePoint,
                                                              Shape::kClustered,
                                                              Shape::kScales),
                                            ::testing::Values(1, 15, 16, 17, 1000)),
                         ShapeName);

TEST(NearestVertex, IsExactBetweenShapesFarApart) {
  const Eigen::Matrix3Xf vertices = Points(Shape::kRandom, 1000, 1);
  const Eigen::Matrix3Xf queries = Points(Shape::kRandom, 500, 2).array() + 20000.0F;
  const std::unique_ptr<const NearestVertex> index = NearestVertex::Build(vertices);
  EXPECT_EQ(Search(*index, queries), BruteForce(vertices, queries));
}

TEST(NearestVertex, GivesAllVerticesOfASphereSeenFromItsCentreTheirTie) {
  // Every vertex (+-a, +-b, +-c) is at exactly the same distance: the lowest index wins.
  Eigen::Matrix3Xf vertices(3, 512);
  for (Eigen::Index i = 0; i < 512; ++i) {
    vertices.col(i) << ((i & 1) != 0 ? 3.0F : -3.0F), ((i & 2) != 0 ? 5.0F : -5.0F),
        ((i & 4) != 0 ? 7.0F : -7.0F);
  }
  const Found found = Search(*NearestVertex::Build(vertices), Eigen::Matrix3Xf::Zero(3, 1));
  EXPECT_EQ(found.indices, std::vector<int32_t>{0});
}

TEST(NearestVertex, KeepsTheVerticesAsGiven) {
  const Eigen::Matrix3Xf vertices = Points(Shape::kRandom, 100, 1);
  EXPECT_EQ(NearestVertex::Build(vertices)->Vertices(), vertices);
}

TEST(NearestVertex, AcceptsNoQueries) {
  const std::unique_ptr<const NearestVertex> index =
      NearestVertex::Build(Points(Shape::kRandom, 3, 1));
  index->Find(Eigen::Matrix3Xf(3, 0), {}, {});
}

TEST(NearestVertex, AnswersTheSameFromSeveralThreads) {
  const std::unique_ptr<const NearestVertex> index =
      NearestVertex::Build(Points(Shape::kGrid, 1000, 1));
  const Eigen::Matrix3Xf queries = Points(Shape::kRandom, 1000, 2);
  const Found expected = Search(*index, queries);
  Found first;
  Found second;
  std::thread other([&] { first = Search(*index, queries); });
  second = Search(*index, queries);
  other.join();
  EXPECT_EQ(first, expected);
  EXPECT_EQ(second, expected);
}

}  // namespace
}  // namespace cohort
