#include "common/jobs/preview_blobs.h"

#include <array>
#include <limits>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/byte_io.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::StatusIs;

constexpr auto kDataLoss = absl::StatusCode::kDataLoss;

std::string SomeCorrespondences() {
  CorrespondencePart part{.meshes = {4, 9}, .fields = DisplacementFields(7)};
  part.fields.Add(Eigen::Matrix3Xf::Constant(3, 7, 1.5F));
  part.fields.Add(Eigen::Matrix3Xf::Constant(3, 7, -2.0F));
  return EncodeCorrespondenceBlob(part);
}

/// As Cohort wrote it before there were steps: two meshes of one vertex.
std::string SomeFloatCorrespondences(float last) {
  ByteWriter writer;
  writer.PutBytes("COHCORR1");
  writer.Put<uint64_t>(1);
  writer.Put<uint64_t>(2);
  writer.PutArray<int32_t>(std::array<int32_t, 2>{4, 9});
  writer.PutArray<float>(std::array<float, 6>{0, 1.5F, -3, 0.25F, -40, last});
  return std::move(writer).Take();
}

std::string SomePreview() {
  return EncodePreviewBlob({.rows = {0, 1}, .columns = {2}, .values = {0.5, 0.25}});
}

TEST(CorrespondenceBlob, ComesBackAsItWas) {
  const auto part = DecodeCorrespondenceBlob(SomeCorrespondences());
  ASSERT_THAT(part, IsOk());
  EXPECT_THAT(part->meshes, ElementsAre(4, 9));
  ASSERT_EQ(part->fields.MeshCount(), 2);
  EXPECT_EQ(part->fields.VertexCount(), 7);
  EXPECT_EQ(part->fields.Of(0)(0, 0), 1.5);
  EXPECT_EQ(part->fields.Of(1)(2, 6), -2.0);
}

TEST(CorrespondenceBlob, OfTheFirstVersionIsReadAndRounded) {
  const auto part = DecodeCorrespondenceBlob(SomeFloatCorrespondences(0.126F));
  ASSERT_THAT(part, IsOk());
  EXPECT_THAT(part->meshes, ElementsAre(4, 9));
  ASSERT_EQ(part->fields.MeshCount(), 2);
  EXPECT_EQ(part->fields.Of(0), Eigen::Vector3d(0, 1.5, -3));
  // In steps of 2^-7, the least for 40 mm.
  EXPECT_EQ(part->fields.Of(1), Eigen::Vector3d(0.25, -40, 0.125));
}

TEST(CorrespondenceBlob, OfTheFirstVersionWithoutAPlaceIsRefused) {
  const std::string bytes = SomeFloatCorrespondences(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(DecodeCorrespondenceBlob(bytes), StatusIs(kDataLoss, "not finite"));
}

/// Products of such values would not be exact any more.
TEST(CorrespondenceBlob, WithStepsOrValuesOutOfRangeIsRefused) {
  constexpr size_t kStepAt = 8 + 8 + 8 + 2 * 4;  // magic, two counts, two indices
  std::string too_large = SomeCorrespondences();
  too_large.replace(kStepAt + 4, 2, "\x00\x20", 2);
  EXPECT_THAT(DecodeCorrespondenceBlob(too_large), StatusIs(kDataLoss, "out of range"));
  std::string too_coarse = SomeCorrespondences();
  too_coarse.replace(kStepAt, 4, "\x75\x00\x00\x00", 4);
  EXPECT_THAT(DecodeCorrespondenceBlob(too_coarse), StatusIs(kDataLoss, "2^117"));
}

TEST(PreviewBlob, ComesBackAsItWas) {
  const auto block = DecodePreviewBlob(SomePreview());
  ASSERT_THAT(block, IsOk());
  EXPECT_THAT(block->rows, ElementsAre(0, 1));
  EXPECT_THAT(block->columns, ElementsAre(2));
  EXPECT_THAT(block->values, ElementsAre(0.5, 0.25));
}

TEST(PreviewBlobs, CutAnywhereOrTooLongAreRefused) {
  const std::string correspondences = SomeCorrespondences();
  const std::string floats = SomeFloatCorrespondences(1);
  const std::string preview = SomePreview();
  for (size_t size = 0; size < floats.size(); ++size) {
    EXPECT_THAT(DecodeCorrespondenceBlob(floats.substr(0, size)), StatusIs(kDataLoss, "blob of"));
  }
  for (size_t size = 0; size < correspondences.size(); ++size) {
    EXPECT_THAT(DecodeCorrespondenceBlob(correspondences.substr(0, size)),
                StatusIs(kDataLoss, "blob of"));
  }
  for (size_t size = 0; size < preview.size(); ++size) {
    EXPECT_THAT(DecodePreviewBlob(preview.substr(0, size)), StatusIs(kDataLoss, "blob of"));
  }
  EXPECT_THAT(DecodeCorrespondenceBlob(floats + "x"), StatusIs(kDataLoss, "blob of"));
  EXPECT_THAT(DecodeCorrespondenceBlob(correspondences + "x"), StatusIs(kDataLoss, "blob of"));
  EXPECT_THAT(DecodePreviewBlob(preview + "x"), StatusIs(kDataLoss, "blob of"));
}

TEST(PreviewBlobs, CountsBeyondTheBytesAreRefusedBeforeMemoryIsTaken) {
  for (const size_t count_at : {size_t{8}, size_t{16}}) {
    std::string correspondences = SomeCorrespondences();
    correspondences.replace(count_at, 8, "\xff\xff\xff\xff\xff\xff\xff\x1f");
    EXPECT_THAT(DecodeCorrespondenceBlob(correspondences), StatusIs(kDataLoss, "blob of"));
    std::string preview = SomePreview();
    preview.replace(count_at, 8, "\xff\xff\xff\xff\xff\xff\xff\x1f");
    EXPECT_THAT(DecodePreviewBlob(preview), StatusIs(kDataLoss, "blob of"));
  }
}

}  // namespace
}  // namespace cohort
