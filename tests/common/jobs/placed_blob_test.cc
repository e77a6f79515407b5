#include "common/jobs/placed_blob.h"

#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "tests/testing/bits.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::BitsOf;
using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;

constexpr auto kDataLoss = absl::StatusCode::kDataLoss;
constexpr size_t kCountAt = 8;      // after the magic
constexpr size_t kVerticesAt = 20;  // after the count and the first mesh's index
constexpr size_t kFirstXAt = 28;

std::vector<PlacedMesh> SomeMeshes() {
  std::vector<PlacedMesh> meshes(2);
  meshes[0].mesh = 2;
  meshes[0].vertices.resize(3, 2);
  meshes[0].vertices << 1.0F / 3, -0.0F,  //
      1e-40F, 5,                          //
      -123.456F, 3e38F;
  meshes[1].mesh = 7;
  meshes[1].vertices = Eigen::Matrix3Xf::Random(3, 5);
  return meshes;
}

template <typename T>
std::string WithNumberAt(std::string bytes, size_t place, T number) {
  std::memcpy(bytes.data() + place, &number, sizeof(number));
  return bytes;
}

TEST(PlacedBlob, KeepsEveryBit) {
  const std::vector<PlacedMesh> meshes = SomeMeshes();
  const auto decoded = DecodePlacedBlob(EncodePlacedBlob(meshes));
  ASSERT_THAT(decoded, IsOk());
  ASSERT_EQ(decoded->size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*decoded)[i].mesh, meshes[i].mesh);
    EXPECT_EQ(BitsOf((*decoded)[i].vertices), BitsOf(meshes[i].vertices));
  }
}

TEST(PlacedBlob, MayHoldNoMesh) {
  const auto decoded = DecodePlacedBlob(EncodePlacedBlob({}));
  ASSERT_THAT(decoded, IsOk());
  EXPECT_TRUE(decoded->empty());
}

TEST(PlacedBlob, IsRefusedWhenCutAtAnyByteOrTooLong) {
  const std::string bytes = EncodePlacedBlob(SomeMeshes());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THAT(DecodePlacedBlob(bytes.substr(0, size)), StatusIs(kDataLoss, "placed blob"))
        << "cut to " << size;
  }
  EXPECT_THAT(DecodePlacedBlob(bytes + "x"), StatusIs(kDataLoss, "1 bytes too many"));
}

TEST(PlacedBlob, IsRefusedWhenItAnnouncesMoreThanItHolds) {
  const std::string bytes = EncodePlacedBlob(SomeMeshes());
  const uint64_t huge = std::numeric_limits<uint64_t>::max() / 12 + 1;
  EXPECT_THAT(DecodePlacedBlob(WithNumberAt(bytes, kCountAt, huge)),
              StatusIs(kDataLoss, "announces"));
  EXPECT_THAT(DecodePlacedBlob(WithNumberAt(bytes, kVerticesAt, huge)),
              StatusIs(kDataLoss, "announces"));
  EXPECT_THAT(DecodePlacedBlob(WithNumberAt(bytes, kVerticesAt, uint64_t{0})),
              StatusIs(kDataLoss, "mesh 2 has no vertices"));
}

TEST(PlacedBlob, IsRefusedWithNumbersThatAreNotFinite) {
  const std::string bytes = EncodePlacedBlob(SomeMeshes());
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_THAT(DecodePlacedBlob(WithNumberAt(bytes, kFirstXAt, bad)),
                StatusIs(kDataLoss, "mesh 2 is not finite"));
  }
}

TEST(PlacedBlob, IsRefusedWithMeshesThatDoNotAscend) {
  std::vector<PlacedMesh> meshes = SomeMeshes();
  meshes[1].mesh = 2;
  EXPECT_THAT(DecodePlacedBlob(EncodePlacedBlob(meshes)), StatusIs(kDataLoss, "mesh 2 after 2"));
  meshes[0].mesh = -1;
  EXPECT_THAT(DecodePlacedBlob(EncodePlacedBlob(meshes)), StatusIs(kDataLoss, "mesh -1 after -1"));
}

}  // namespace
}  // namespace cohort
