#include "common/geometry/nearest/packed_surface.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

TEST(PackedSurface, HoldsEveryFaceOnceAndRepeatsTheLast) {
  for (const int size : {1, 15, 16, 17, 31, 33, 256, 257, 4097}) {
    Random random(21);
    Eigen::Matrix3Xf vertices(3, 500);
    Matrix3Xi triples(3, size);
    for (float& coordinate : vertices.reshaped()) {
      coordinate = static_cast<float>(random.Uniform(-80, 80));
    }
    for (int32_t& vertex : triples.reshaped()) {
      vertex = static_cast<int32_t>(random.Below(500));
    }
    const PackedSurface packed(vertices, triples);
    ASSERT_EQ(packed.SlotCount(), (size + 15) / 16 * 16);
    ASSERT_EQ(packed.FaceCount(), size);
    std::vector<int32_t> faces(packed.FaceOfSlot().begin(), packed.FaceOfSlot().begin() + size);
    for (size_t slot = 1; slot < static_cast<size_t>(packed.SlotCount()); ++slot) {
      if (slot % 16 != 0) {
        EXPECT_LE(packed.FaceOfSlot()[slot - 1], packed.FaceOfSlot()[slot]);
      }
      if (slot >= static_cast<size_t>(size)) {
        EXPECT_EQ(packed.FaceOfSlot()[slot], faces.back());
      }
    }
    std::sort(faces.begin(), faces.end());
    for (int i = 0; i < size; ++i) {
      EXPECT_EQ(faces[static_cast<size_t>(i)], i);
    }
  }
}

TEST(PackedSurfaceDeathTest, RefusesAPointCloudAndAFaceOutOfRange) {
  const Eigen::Matrix3Xf vertices = Eigen::Matrix3Xf::Zero(3, 3);
  EXPECT_DEATH(PackedSurface(vertices, Matrix3Xi(3, 0)), "faces.cols");
  EXPECT_DEATH(PackedSurface(vertices, Eigen::Vector3i(0, 1, 3)), "vertices.cols");
}

}  // namespace
}  // namespace cohort
