#include "common/report/color_map.h"

#include <limits>

#include <gtest/gtest.h>

namespace cohort {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The approximation may differ from the published table by this much per channel.
constexpr int kTolerance = 2;

void ExpectNear(Rgb actual, Rgb expected) {
  EXPECT_NEAR(actual.red, expected.red, kTolerance);
  EXPECT_NEAR(actual.green, expected.green, kTolerance);
  EXPECT_NEAR(actual.blue, expected.blue, kTolerance);
}

double Luma(Rgb color) {
  return 0.2126 * color.red + 0.7152 * color.green + 0.0722 * color.blue;
}

TEST(MapColor, AgreesWithThePublishedViridis) {
  // matplotlib's _viridis_data[0, 64, 128, 192, 255], times 255.
  EXPECT_EQ(MapColor(0), (Rgb{68, 1, 84}));
  ExpectNear(MapColor(64 / 255.0), {59, 82, 139});
  ExpectNear(MapColor(128 / 255.0), {33, 145, 140});
  ExpectNear(MapColor(192 / 255.0), {94, 201, 98});
  EXPECT_EQ(MapColor(1), (Rgb{253, 231, 37}));
}

TEST(MapColor, NeverGetsDarker) {
  double previous = 0;
  for (int i = 0; i <= 255; ++i) {
    const double luma = Luma(MapColor(i / 255.0));
    EXPECT_GE(luma, previous - 0.5) << i;  // Half a step of rounding.
    previous = luma;
  }
}

TEST(MapColor, ClampsAndShowsMissingValuesInGrey) {
  EXPECT_EQ(MapColor(-3), MapColor(0));
  EXPECT_EQ(MapColor(7), MapColor(1));
  EXPECT_EQ(MapColor(kNaN), kNoValueColor);
}

TEST(MapDivergingColor, AgreesWithThePublishedTable) {
  // Moreland's CoolWarmFloat33 at 0, 8, 16, 24, 32 of 32.
  EXPECT_EQ(MapDivergingColor(-1), (Rgb{59, 76, 192}));
  ExpectNear(MapDivergingColor(-0.5), {141, 176, 254});
  EXPECT_EQ(MapDivergingColor(0), (Rgb{221, 221, 221}));
  ExpectNear(MapDivergingColor(0.5), {244, 154, 123});
  EXPECT_EQ(MapDivergingColor(1), (Rgb{180, 4, 38}));
}

TEST(MapDivergingColor, BothArmsGetDarkerFromTheMiddle) {
  for (int i = 1; i <= 16; ++i) {
    EXPECT_LT(Luma(MapDivergingColor(i / 16.0)), Luma(MapDivergingColor((i - 1) / 16.0)) + 0.5);
    EXPECT_LT(Luma(MapDivergingColor(-i / 16.0)), Luma(MapDivergingColor((1 - i) / 16.0)) + 0.5);
  }
}

TEST(ColorScale, DivergingRunsAsFarOnBothSidesOfZero) {
  const ColorScale scale{.map = ColorScale::Map::kDiverging, .low = -1, .high = 3};
  EXPECT_EQ(scale.First(), -3);
  EXPECT_EQ(scale.Last(), 3);
  EXPECT_EQ(scale.ColorOf(0), MapDivergingColor(0));
  EXPECT_EQ(scale.ColorOf(-1.5), MapDivergingColor(-0.5));
  EXPECT_EQ(scale.ColorOf(7), MapDivergingColor(1));
}

TEST(ColorScale, OutsideTheThresholdsIsGrey) {
  const ColorScale scale{.low = 1, .high = 2, .lower_threshold = 1.2, .upper_threshold = 2.5};
  EXPECT_EQ(scale.ColorOf(1.19), kNoValueColor);
  EXPECT_EQ(scale.ColorOf(1.2), MapColor(0.2));
  EXPECT_EQ(scale.ColorOf(2.4), MapColor(1));
  EXPECT_EQ(scale.ColorOf(2.51), kNoValueColor);
  EXPECT_EQ(scale.ColorOf(kNaN), kNoValueColor);
}

TEST(ColorScale, AConstantHasTheMiddleColour) {
  EXPECT_EQ((ColorScale{.low = 2, .high = 2}).ColorOf(2), MapColor(0.5));
  EXPECT_EQ((ColorScale{.map = ColorScale::Map::kDiverging, .low = 0, .high = 0}).ColorOf(0),
            MapDivergingColor(0));
}

TEST(InkOn, IsWhiteOnDarkAndDarkOnBright) {
  EXPECT_EQ(InkOn(MapColor(0)), kWhite);
  EXPECT_EQ(InkOn(MapColor(1)), kInk);
  EXPECT_EQ(InkOn(kWhite), kInk);
}

}  // namespace
}  // namespace cohort
