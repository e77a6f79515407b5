#include "common/rpc/convert_outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

TEST(ConvertOutputs, GoesThereAndBack) {
  JobOutputs outputs;
  outputs.tiles = {Sha256::Of("tile 1"), Sha256::Of("tile 2")};
  outputs.alignments = {Sha256::Of("alignment")};
  outputs.poses = {Sha256::Of("pose")};
  outputs.fields = {Sha256::Of("field")};
  outputs.mean_shape = Sha256::Of("mean");
  outputs.summary = Sha256::Of("summary");
  outputs.variation_shape = Sha256::Of("shape");
  outputs.base_choice = Sha256::Of("choice");
  outputs.frame = {.reference = Sha256::Of("reference"), .center = {1, -2, 3.5}};
  outputs.imported = {
      {.tiles = {Sha256::Of("old tile")}, .fields = {Sha256::Of("old field")}, .mesh_of = {2, -1}}};
  const auto back = FromProto(ToProto(outputs));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->tiles, outputs.tiles);
  EXPECT_EQ(back->alignments, outputs.alignments);
  EXPECT_EQ(back->poses, outputs.poses);
  EXPECT_EQ(back->fields, outputs.fields);
  EXPECT_EQ(back->mean_shape, outputs.mean_shape);
  EXPECT_EQ(back->summary, outputs.summary);
  EXPECT_EQ(back->variation_shape, outputs.variation_shape);
  EXPECT_EQ(back->base_choice, outputs.base_choice);
  EXPECT_EQ(back->frame, outputs.frame);
  EXPECT_EQ(back->imported, outputs.imported);
}

TEST(ConvertOutputs, RefusesWhatIsNoDigestOrPoint) {
  v1::GetOutputsResponse wire = ToProto(JobOutputs{});
  wire.add_field_sha256("not a digest");
  EXPECT_THAT(FromProto(wire).status(), StatusIs(absl::StatusCode::kInvalidArgument, ""));
  wire = ToProto(JobOutputs{});
  wire.add_frame_center(4);
  EXPECT_THAT(FromProto(wire).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "frame_center"));
}

}  // namespace
}  // namespace cohort
