#include "common/report/render/shape_picture.h"

#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/report/render/image.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/common/report/png_pixels.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::DecodePng;
using ::cohort::testing::IsOk;
using ::cohort::testing::IsOkAndHolds;
using ::cohort::testing::Pixels;
using ::cohort::testing::StatusIs;

// Is what is seen at the place coloured or a shade of grey?
bool IsGrey(Rgb color) {
  return color.red == color.green && color.red == color.blue;
}

TEST(ShapeViewsPng, ValuesOutsideTheThresholdsAreGrey) {
  const TriangleMesh sheet = testing::WavySheet(30);
  std::vector<double> values;  // Left half low, right half high.
  for (int64_t i = 0; i < sheet.VertexCount(); ++i) {
    values.push_back(sheet.vertices(0, i) < 43 ? 0.2 : 0.9);
  }
  ShapeValues shown{.values = values, .scale = {}, .title = "RMS", .unit = "mm"};
  shown.scale.upper_threshold = 0.5;
  const auto png = ShapeViewsPng(sheet, shown, {.view_width = 60});
  ASSERT_THAT(png, IsOk());
  const Pixels pixels = DecodePng(*png);
  // The middle one of three views of 120 pixels.
  EXPECT_FALSE(IsGrey(pixels.At(120 + 40, 60)));
  EXPECT_TRUE(IsGrey(pixels.At(120 + 80, 60)));
}

TEST(ShapeViewsPng, TheLegendShowsTheColoursOfTheScale) {
  const TriangleMesh sheet = testing::WavySheet(10);
  const std::vector<double> values(static_cast<size_t>(sheet.VertexCount()),
                                   std::numeric_limits<double>::quiet_NaN());
  const ShapeValues shown{.values = values,
                          .scale = {.map = ColorScale::Map::kDiverging, .low = -1, .high = 2},
                          .title = "signed",
                          .unit = "mm"};
  const auto png = ShapeViewsPng(sheet, shown, {.view_width = 300});
  ASSERT_THAT(png, IsOk());
  const Pixels pixels = DecodePng(*png);
  // From -2 to 2 in 256 shades; those at the ends lie under the frame.
  EXPECT_GT(pixels.Count(shown.scale.ColorOf(-2 + 4 * 10 / 255.0)), 10);
  EXPECT_GT(pixels.Count(shown.scale.ColorOf(-2 + 4 * 245 / 255.0)), 10);
  EXPECT_EQ(pixels.Count(MapColor(0)), 0);
}

TEST(ShapeViewsPng, GivesTheSameBytesEachTime) {
  const TriangleMesh sheet = testing::WavySheet(12);
  const auto first = ShapeViewsPng(sheet, {.view_width = 50});
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(ShapeViewsPng(sheet, {.view_width = 50}), IsOkAndHolds(*first));
}

TEST(ShapeViewsPng, RefusesValuesOfAnotherNumberOfVertices) {
  const std::vector<double> values(3, 1.0);
  const ShapeValues three{.values = values, .scale = {}, .title = "", .unit = ""};
  EXPECT_THAT(ShapeViewsPng(testing::WavySheet(12), three, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "3 values for 144 vertices"));
  EXPECT_THAT(ShapeViewsPng(TriangleMesh(), ShapePictureOptions{}),
              StatusIs(absl::StatusCode::kInvalidArgument, "no vertex"));
}

TEST(ImagePng, KeepsEveryPixel) {
  const Image image{2, 2, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}}};
  const auto png = ImagePng(image);
  ASSERT_THAT(png, IsOk());
  EXPECT_EQ(DecodePng(*png).colors, image.pixels);
}

TEST(ImagePng, AGreyPictureHasOneByteAPixel) {
  const Image image{2, 1, {{7, 7, 7}, {250, 250, 250}}};
  const auto png = ImagePng(image);
  ASSERT_THAT(png, IsOk());
  EXPECT_EQ((*png)[25], 0);  // Colour type of IHDR: greyscale.
  EXPECT_EQ(DecodePng(*png).colors, image.pixels);
}

TEST(ImagePng, RefusesPixelsThatAreNotWidthTimesHeight) {
  EXPECT_THAT(ImagePng({2, 2, {kWhite}}), StatusIs(absl::StatusCode::kInvalidArgument, "pixels"));
  EXPECT_THAT(ImagePng({0, 0, {}}), StatusIs(absl::StatusCode::kInvalidArgument, "pixels"));
}

}  // namespace
}  // namespace cohort
