#include "common/geometry/nearest/packed_mesh.h"

#include <algorithm>
#include <span>

#include <gtest/gtest.h>

namespace cohort {
namespace {

/// Numbers of a level: one group of 16 children for each 16 of the level below.
size_t LevelFloats(const PackedMesh& mesh, int level) {
  auto groups = static_cast<size_t>(mesh.LeafCount());
  for (int i = 0; i <= level; ++i) {
    groups = (groups + 15) / 16;
  }
  return groups * 96;
}

class PackedMeshCopy : public ::testing::TestWithParam<int> {};

TEST_P(PackedMeshCopy, IsTheSameToTheLastBit) {
  const Eigen::Matrix3Xf vertices = Eigen::Matrix3Xf::Random(3, GetParam()) * 100;
  const PackedMesh packed(vertices);
  const PackedMesh::View& from = packed.Addresses();
  const auto slots = static_cast<size_t>(packed.SlotCount());

  const PackedMesh copy =
      PackedMesh::FromSlots(GetParam(), packed.VertexOfSlot(), {from.points, 3 * slots});

  const PackedMesh::View& to = copy.Addresses();
  ASSERT_EQ(to.leaf_count, from.leaf_count);
  ASSERT_EQ(to.level_count, from.level_count);
  EXPECT_EQ(to.vertex_count, from.vertex_count);
  EXPECT_TRUE(std::ranges::equal(copy.VertexOfSlot(), packed.VertexOfSlot()));
  EXPECT_TRUE(std::equal(to.points, to.points + 3 * slots, from.points));
  EXPECT_TRUE(std::equal(to.boxes, to.boxes + slots / 2, from.boxes));
  for (int level = 0; level < from.level_count; ++level) {
    EXPECT_TRUE(std::equal(to.levels[level], to.levels[level] + LevelFloats(packed, level),
                           from.levels[level]))
        << "level " << level;
  }
  EXPECT_EQ(copy.ByteCount(), packed.ByteCount());
}

INSTANTIATE_TEST_SUITE_P(Vertices, PackedMeshCopy, ::testing::Values(1, 15, 16, 17, 300, 5000));

}  // namespace
}  // namespace cohort
