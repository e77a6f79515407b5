#include "common/geometry/nearest/surface_search.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/base/random.h"
#include "common/geometry/synthetic/demo_cohort.h"

namespace cohort {
namespace {

struct Surface {
  Eigen::Matrix3Xf vertices;
  Matrix3Xi faces;
};

Surface MakeFace(int faces, uint64_t seed) {
  DemoOptions options;
  options.people = 2;
  options.captures = 1;
  options.vertices = std::max(faces, 200);
  options.seed = seed;
  const TriangleMesh mesh = MakeDemoScan(options, 0, 0)->mesh;
  const Eigen::Vector3d middle = mesh.vertices.rowwise().mean();
  return {(mesh.vertices.colwise() - middle).cast<float>(), mesh.faces.leftCols(faces)};
}

PointTransform TurnAndShift() {
  const Eigen::Matrix3d turn =
      1.01 * Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  PointTransform transform{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      transform.rows[row][column] = turn(row, column);
    }
    transform.rows[row][3] = 1 - row;
  }
  return transform;
}

/// The sums as they are defined, over the kept lanes.
PairSums DefinedSums(const PackedMesh& queries,
                     const NearestOnSurface& nearest,
                     const AlignedArray<uint16_t>& kept) {
  PairSums sums;
  for (int slot = 0; slot < queries.SlotCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    if ((kept[s / 16] >> (s % 16) & 1) == 0) {
      continue;
    }
    const Eigen::Vector3d a = queries.PointOfSlot(slot).cast<double>();
    const Eigen::Vector3d b = nearest.PointOfSlot(slot).cast<double>();
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

TEST(SurfacePairSums, AreThoseOfTheDefinitionAndTheSameOnEveryPath) {
  const Surface surface = MakeFace(2000, 12);
  const PackedSurface target(surface.vertices, surface.faces);
  for (const int size : {1, 16, 17, 300, 1003}) {
    const PackedMesh queries(MakeFace(2000, 11).vertices.leftCols(size));
    const AlignedArray<uint16_t> all = AllVertices(queries);
    NearestOnSurface nearest;
    const PairSums first =
        SurfaceSearch(InstructionSet::kPortable)
            .FindMovedAndSum(queries, TurnAndShift(), target, SearchSeed::kDescent, nearest);
    EXPECT_EQ(first.count, size);
    for (const InstructionSet set : AvailableInstructionSets()) {
      SurfaceSearch search(set);
      ExpectSameBits(
          search.FindMovedAndSum(queries, TurnAndShift(), target, SearchSeed::kPrevious, nearest),
          first);
      ExpectNear(first, DefinedSums(queries, nearest, all));
      ExpectSameBits(search.Sum(queries, nearest, {all.data(), all.size()}), first);
    }
  }
}

TEST(SurfacePairSums, LeaveOutTheLanesThatAreNotKept) {
  const Surface surface = MakeFace(2000, 14);
  const PackedSurface target(surface.vertices, surface.faces);
  const PackedMesh queries(MakeFace(2000, 13).vertices.leftCols(1003));
  AlignedArray<uint16_t> kept = AllVertices(queries);
  Random random(15);
  for (size_t leaf = 0; leaf < kept.size(); ++leaf) {
    kept[leaf] = static_cast<uint16_t>(kept[leaf] & random.NextBits());
  }
  for (const InstructionSet set : AvailableInstructionSets()) {
    SurfaceSearch search(set);
    NearestOnSurface nearest;
    search.Find(queries, target, nearest);
    ExpectNear(search.Sum(queries, nearest, {kept.data(), kept.size()}),
               DefinedSums(queries, nearest, kept));
  }
}

}  // namespace
}  // namespace cohort
