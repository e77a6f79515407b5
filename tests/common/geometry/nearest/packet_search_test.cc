#include "common/geometry/nearest/packet_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/base/random.h"
#include "common/geometry/nearest/nearest_vertex.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

enum class Shape { kGrid, kPlane, kLine, kDuplicates, kOnePoint, kClustered, kScales, kFace };

Eigen::Matrix3Xf FaceVertices(int count, uint64_t seed) {
  DemoOptions options;
  options.people = 2;
  options.captures = 1;
  options.vertices = std::max(count, 200);
  options.seed = seed;
  const Eigen::Matrix3Xd vertices = MakeDemoScan(options, 0, 0)->mesh.vertices;
  const Eigen::Vector3d middle = vertices.rowwise().mean();
  return (vertices.colwise() - middle).cast<float>().leftCols(count);
}

Eigen::Matrix3Xf MakeShape(Shape shape, int count, uint64_t seed) {
  if (shape == Shape::kFace) {
    return FaceVertices(count, seed);
  }
  Random random(seed);
  Eigen::Matrix3Xf points(3, count);
  const auto uniform = [&random] { return static_cast<float>(random.Uniform(-80, 80)); };
  for (int i = 0; i < count; ++i) {
    switch (shape) {
      case Shape::kGrid:
        points.col(i) << static_cast<float>(random.Below(6)), static_cast<float>(random.Below(6)),
            static_cast<float>(random.Below(6));
        break;
      case Shape::kPlane:
        points.col(i) << uniform(), uniform(), 0;
        break;
      case Shape::kLine:
        points.col(i) << uniform(), 0, 0;
        break;
      case Shape::kDuplicates:
        points.col(i) << static_cast<float>(i / 5 % 7), -3, static_cast<float>(i % 3);
        break;
      case Shape::kOnePoint:
        points.col(i) << 1, 2, 3;
        break;
      case Shape::kClustered: {
        const auto cluster = static_cast<float>(random.Below(4));
        points.col(i) << cluster * 50 + 1e-3F * uniform(), 1e-3F * uniform(), 1e-3F * uniform();
        break;
      }
      case Shape::kScales:
        points.col(i) = Eigen::Vector3f(uniform(), uniform(), uniform()) *
                        std::pow(10.0F, static_cast<float>(random.Uniform(-24, 12)));
        break;
      case Shape::kFace:
        break;
    }
  }
  return points;
}

float SquaredDistance(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f d = a - b;
  return std::fma(d.x(), d.x(), std::fma(d.y(), d.y(), d.z() * d.z()));
}

struct Nearest {
  int32_t vertex = -1;
  float squared_distance = std::numeric_limits<float>::infinity();
};

Nearest BruteForce(const Eigen::Vector3f& query, const Eigen::Matrix3Xf& target) {
  Nearest nearest;
  for (int v = 0; v < target.cols(); ++v) {
    const float distance = SquaredDistance(query, target.col(v));
    if (distance < nearest.squared_distance) {
      nearest = {v, distance};
    }
  }
  return nearest;
}

/// Each slot's result is that of brute force, to the bit.
void ExpectExact(const PackedMesh& queries,
                 const Eigen::Matrix3Xf& points,
                 const PackedMesh& target,
                 const Eigen::Matrix3Xf& target_points,
                 const NearestSlots& nearest) {
  for (int slot = 0; slot < queries.SlotCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    const Eigen::Vector3f query = points.col(queries.VertexOfSlot()[s]);
    const Nearest expected = BruteForce(query, target_points);
    const auto found = static_cast<size_t>(nearest.slots[s]);
    ASSERT_EQ(target.VertexOfSlot()[found], expected.vertex) << "slot " << slot;
    ASSERT_EQ(std::bit_cast<uint32_t>(nearest.squared_distances[s]),
              std::bit_cast<uint32_t>(expected.squared_distance))
        << "slot " << slot;
  }
}

class PacketSearchPath : public ::testing::TestWithParam<std::tuple<InstructionSet, Shape>> {};

TEST_P(PacketSearchPath, FindsWhatBruteForceFinds) {
  const auto [set, shape] = GetParam();
  PacketSearch search(set);
  NearestSlots nearest;
  uint64_t seed = 1;
  for (const int queries_size : {1, 15, 16, 17, 700}) {
    for (const int target_size : {1, 15, 16, 17, 255, 257, 1500}) {
      const Eigen::Matrix3Xf points = MakeShape(shape, queries_size, ++seed);
      const Eigen::Matrix3Xf target_points = MakeShape(shape, target_size, ++seed);
      const PackedMesh queries(points);
      const PackedMesh target(target_points);
      search.Find(queries, target, nearest);
      ExpectExact(queries, points, target, target_points, nearest);
    }
  }
}

TEST_P(PacketSearchPath, FindsFromAfarAndBetweenUnlikeShapes) {
  const auto [set, shape] = GetParam();
  PacketSearch search(set);
  NearestSlots nearest;
  const Eigen::Matrix3Xf points =
      MakeShape(shape, 400, 5).colwise() + Eigen::Vector3f(900, -2000, 30);
  for (const Shape other : {Shape::kFace, Shape::kGrid, Shape::kLine}) {
    const Eigen::Matrix3Xf target_points = MakeShape(other, 900, 6);
    const PackedMesh queries(points);
    const PackedMesh target(target_points);
    search.Find(queries, target, nearest);
    ExpectExact(queries, points, target, target_points, nearest);
  }
}

TEST_P(PacketSearchPath, FindsForMovedQueriesFromAnySeed) {
  const auto [set, shape] = GetParam();
  PacketSearch search(set);
  const Eigen::Matrix3Xf points = MakeShape(shape, 333, 7);
  const Eigen::Matrix3Xf target_points = MakeShape(shape, 777, 8);
  const PackedMesh queries(points);
  const PackedMesh target(target_points);
  const Eigen::Matrix3d turn =
      1.01 * Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(1, -2, 0.5);
  PointTransform transform{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      transform.rows[row][column] = turn(row, column);
    }
    transform.rows[row][3] = shift[row];
  }
  Eigen::Matrix3Xf moved(3, points.cols());
  for (int i = 0; i < points.cols(); ++i) {
    for (int row = 0; row < 3; ++row) {
      const double* m = transform.rows[row];
      moved(row, i) =
          static_cast<float>(m[0] * double{points(0, i)} +
                             (m[1] * double{points(1, i)} + (m[2] * double{points(2, i)} + m[3])));
    }
  }
  NearestSlots nearest;
  search.FindMoved(queries, transform, target, SearchSeed::kDescent, nearest);
  ExpectExact(queries, moved, target, target_points, nearest);
  Random random(3);
  for (size_t s = 0; s < nearest.slots.size(); ++s) {
    nearest.slots[s] = static_cast<int32_t>(random.Below(target.SlotCount()));
  }
  search.FindMoved(queries, transform, target, SearchSeed::kPrevious, nearest);
  ExpectExact(queries, moved, target, target_points, nearest);
  search.FindMoved(queries, transform, target, SearchSeed::kPrevious, nearest);
  ExpectExact(queries, moved, target, target_points, nearest);
}

INSTANTIATE_TEST_SUITE_P(All,
                         PacketSearchPath,
                         ::testing::Combine(::testing::ValuesIn(AvailableInstructionSets()),
                                            ::testing::Values(Shape::kGrid,
                                                              Shape::kPlane,
                                                              Shape::kLine,
                                                              Shape::kDuplicates,
                                                              Shape::kOnePoint,
                                                              Shape::kClustered,
                                                              Shape::kScales,
                                                              Shape::kFace)));

TEST(PacketSearch, AgreesWithNanoflannOnFaces) {
  const Eigen::Matrix3Xf points = FaceVertices(5000, 3);
  const Eigen::Matrix3Xf target_points = FaceVertices(5200, 4);
  const PackedMesh queries(points);
  const PackedMesh target(target_points);
  std::vector<int32_t> indices(5000);
  std::vector<float> distances(5000);
  NearestVertex::Build(target_points)->Find(points, indices, distances);
  for (const InstructionSet set : AvailableInstructionSets()) {
    NearestSlots nearest;
    PacketSearch(set).Find(queries, target, nearest);
    for (size_t s = 0; s < 5000; ++s) {
      const auto vertex = static_cast<size_t>(queries.VertexOfSlot()[s]);
      const auto found = static_cast<size_t>(nearest.slots[s]);
      ASSERT_EQ(target.VertexOfSlot()[found], indices[vertex]);
      ASSERT_EQ(nearest.squared_distances[s], distances[vertex]);
    }
  }
}

/// The sums as they are defined, over the kept lanes.
PairSums DefinedSums(const PackedMesh& queries,
                     const PackedMesh& target,
                     const NearestSlots& nearest,
                     const AlignedArray<uint16_t>& kept) {
  PairSums sums;
  for (int slot = 0; slot < queries.SlotCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    if ((kept[s / 16] >> (s % 16) & 1) == 0) {
      continue;
    }
    const Eigen::Vector3d a = queries.PointOfSlot(slot).cast<double>();
    const Eigen::Vector3d b = target.PointOfSlot(nearest.slots[s]).cast<double>();
    ++sums.count;
    sums.a += a;
    sums.b += b;
    sums.aa += a.squaredNorm();
    sums.bb += b.squaredNorm();
    sums.squared_distance += nearest.squared_distances[s];
    sums.distance += std::sqrt(nearest.squared_distances[s]);
    sums.ba += b * a.transpose();
  }
  return sums;
}

void ExpectNear(const PairSums& actual, const PairSums& expected) {
  EXPECT_EQ(actual.count, expected.count);
  EXPECT_TRUE(actual.a.isApprox(expected.a, 1e-12));
  EXPECT_TRUE(actual.b.isApprox(expected.b, 1e-12));
  EXPECT_TRUE(actual.ba.isApprox(expected.ba, 1e-12));
  EXPECT_NEAR(actual.aa, expected.aa, 1e-12 * expected.aa);
  EXPECT_NEAR(actual.bb, expected.bb, 1e-12 * expected.bb);
  EXPECT_NEAR(actual.squared_distance, expected.squared_distance,
              1e-12 * expected.squared_distance);
  EXPECT_NEAR(actual.distance, expected.distance, 1e-12 * expected.distance);
}

void ExpectSameBits(const PairSums& actual, const PairSums& expected) {
  EXPECT_EQ(actual.count, expected.count);
  EXPECT_EQ(actual.a, expected.a);
  EXPECT_EQ(actual.b, expected.b);
  EXPECT_EQ(actual.ba, expected.ba);
  EXPECT_EQ(actual.aa, expected.aa);
  EXPECT_EQ(actual.bb, expected.bb);
  EXPECT_EQ(actual.squared_distance, expected.squared_distance);
  EXPECT_EQ(actual.distance, expected.distance);
}

constexpr PointTransform kIdentity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

TEST(PairSums, AreThoseOfTheDefinitionAndTheSameOnEveryPath) {
  for (const int size : {1, 16, 17, 300, 4099}) {
    const PackedMesh queries(FaceVertices(size, 11));
    const PackedMesh target(FaceVertices(1000, 12));
    const AlignedArray<uint16_t> all = AllVertices(queries);
    PairSums first;
    for (const InstructionSet set : AvailableInstructionSets()) {
      NearestSlots nearest;
      const PairSums sums = PacketSearch(set).FindMovedAndSum(queries, kIdentity, target,
                                                              SearchSeed::kDescent, nearest);
      EXPECT_EQ(sums.count, size);
      ExpectNear(sums, DefinedSums(queries, target, nearest, all));
      if (set == InstructionSet::kPortable) {
        first = sums;
      }
      ExpectSameBits(sums, first);
    }
  }
}

TEST(PairSums, LeaveOutTheLanesThatAreNotKept) {
  const PackedMesh queries(FaceVertices(1003, 13));
  const PackedMesh target(FaceVertices(1000, 14));
  AlignedArray<uint16_t> kept = AllVertices(queries);
  Random random(15);
  for (size_t leaf = 0; leaf < kept.size(); ++leaf) {
    kept[leaf] = static_cast<uint16_t>(kept[leaf] & random.NextBits());
  }
  for (const InstructionSet set : AvailableInstructionSets()) {
    PacketSearch search(set);
    NearestSlots nearest;
    search.Find(queries, target, nearest);
    ExpectNear(search.Sum(queries, target, nearest, {kept.data(), kept.size()}),
               DefinedSums(queries, target, nearest, kept));
  }
}

TEST(PackedMesh, HoldsEveryVertexOnceAndRepeatsTheLast) {
  for (const int size : {1, 15, 16, 17, 31, 33, 256, 257, 4097}) {
    const Eigen::Matrix3Xf points = MakeShape(Shape::kPlane, size, 21);
    const PackedMesh mesh(points);
    ASSERT_EQ(mesh.SlotCount(), (size + 15) / 16 * 16);
    std::vector<int32_t> vertices(mesh.VertexOfSlot().begin(), mesh.VertexOfSlot().begin() + size);
    for (int slot = 0; slot < mesh.SlotCount(); ++slot) {
      const int32_t vertex = mesh.VertexOfSlot()[static_cast<size_t>(slot)];
      EXPECT_EQ(mesh.PointOfSlot(slot), points.col(vertex));
      if (slot % 16 != 0) {
        EXPECT_LE(mesh.VertexOfSlot()[static_cast<size_t>(slot) - 1], vertex);
      }
      if (slot >= size) {
        EXPECT_EQ(vertex, vertices.back());
      }
    }
    std::sort(vertices.begin(), vertices.end());
    for (int i = 0; i < size; ++i) {
      EXPECT_EQ(vertices[static_cast<size_t>(i)], i);
    }
  }
}

class ForcedInstructionSet : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("COHORT_ISA"); }
};

TEST_F(ForcedInstructionSet, IsTheFastestUnlessAskedFor) {
  unsetenv("COHORT_ISA");
  EXPECT_EQ(*ChooseInstructionSet(), AvailableInstructionSets().back());
  setenv("COHORT_ISA", "", 1);
  EXPECT_EQ(*ChooseInstructionSet(), AvailableInstructionSets().back());
  setenv("COHORT_ISA", "portable", 1);
  EXPECT_EQ(*ChooseInstructionSet(), InstructionSet::kPortable);
}

TEST_F(ForcedInstructionSet, RefusesWhatDoesNotExist) {
  setenv("COHORT_ISA", "avx1024", 1);
  EXPECT_THAT(ChooseInstructionSet(),
              testing::StatusIs(absl::StatusCode::kInvalidArgument, "avx1024"));
}

}  // namespace
}  // namespace cohort
