#include "common/jobs/preview_blobs.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

std::string SomePreview() {
  return EncodePreviewBlob({.rows = {0, 1}, .columns = {2}, .values = {0.5, 0.25}});
}

TEST(CorrespondenceBlob, ComesBackAsItWas) {
  const auto part = DecodeCorrespondenceBlob(SomeCorrespondences());
  ASSERT_THAT(part, IsOk());
  EXPECT_THAT(part->meshes, ElementsAre(4, 9));
  ASSERT_EQ(part->fields.MeshCount(), 2);
  EXPECT_EQ(part->fields.VertexCount(), 7);
  EXPECT_EQ(part->fields.Of(1)(2, 6), -2.0F);
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
  const std::string preview = SomePreview();
  for (size_t size = 0; size < correspondences.size(); ++size) {
    EXPECT_THAT(DecodeCorrespondenceBlob(correspondences.substr(0, size)),
                StatusIs(kDataLoss, "blob of"));
  }
  for (size_t size = 0; size < preview.size(); ++size) {
    EXPECT_THAT(DecodePreviewBlob(preview.substr(0, size)), StatusIs(kDataLoss, "blob of"));
  }
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
